import { history, historyKeymap, standardKeymap } from "@codemirror/commands";
import { json } from "@codemirror/lang-json";
import { bracketMatching, indentOnInput, syntaxHighlighting } from "@codemirror/language";
import { diagnosticCount, setDiagnostics } from "@codemirror/lint";
import { type Extension, Transaction } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { tagHighlighter, tags } from "@lezer/highlight";
import { Input } from "@mantine/core";
import { type RefObject, useEffect, useEffectEvent, useLayoutEffect, useRef } from "react";
import type { FieldError } from "./form/write";
import classes from "./JsonCode.module.css";
import { placeErrors } from "./jsonPlaces";

interface JsonCodeProps {
  /** Of the element that has the text; those of its label and description begin with it. */
  id: string;
  text: string;
  onChange: (text: string) => void;
  errors: readonly FieldError[];
  className: string | undefined;
  /** Whether what stood here while this was loaded had the focus. */
  focused: RefObject<boolean>;
}

/** JSON with its errors marked. Tab and Escape are not used: they leave the field and stop robots as everywhere. */
export default function JsonCode({ id, text, onChange, errors, className, focused }: JsonCodeProps) {
  const host = useRef<HTMLDivElement>(null);
  const shown = useRef<EditorView>(null);
  const change = useEffectEvent(onChange);

  useLayoutEffect(() => {
    if (host.current === null) return;
    const attributes = EditorView.contentAttributes.of(({ state }) => ({
      id,
      "aria-labelledby": `${id}-label`,
      "aria-describedby": `${id}-description`,
      "aria-invalid": String(diagnosticCount(state) > 0),
    }));
    const listener = EditorView.updateListener.of(({ docChanged, transactions, state }) => {
      const typed = !transactions.some((transaction) => transaction.annotation(Transaction.remote));
      if (docChanged && typed) change(state.doc.toString());
    });
    const view = new EditorView({ parent: host.current, extensions: [EXTENSIONS, attributes, listener] });
    shown.current = view;
    return () => view.destroy();
  }, [id]);

  useLayoutEffect(() => {
    const view = shown.current;
    if (view === null || view.state.doc.toString() === text) return;
    view.dispatch({
      changes: { from: 0, to: view.state.doc.length, insert: text },
      annotations: Transaction.remote.of(true),
    });
  }, [text]);

  useLayoutEffect(() => {
    const view = shown.current;
    view?.dispatch(setDiagnostics(view.state, placeErrors(view.state.doc.toString(), errors)));
  }, [errors]);

  useEffect(() => {
    if (focused.current) shown.current?.focus();
  }, [focused]);

  return (
    <Input
      component="div"
      multiline
      withAria={false}
      error={errors.length > 0}
      ref={host}
      classNames={{ input: `${className} ${classes.code}` }}
    />
  );
}

const EXTENSIONS: Extension = [
  history(),
  keymap.of([...standardKeymap, ...historyKeymap]),
  json(),
  indentOnInput(),
  bracketMatching(),
  EditorView.lineWrapping,
  syntaxHighlighting(
    tagHighlighter([
      { tag: tags.propertyName, class: classes.property ?? "" },
      { tag: tags.string, class: classes.string ?? "" },
      { tag: tags.number, class: classes.number ?? "" },
      { tag: [tags.bool, tags.null], class: classes.constant ?? "" },
    ]),
  ),
];
