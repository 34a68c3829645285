import { ClientError } from "@dock-gateway/client";
import { SegmentedControl } from "@mantine/core";
import { useMemo } from "react";
import { type FormContextValue, FormProvider } from "./fields/context";
import { MessageFields } from "./fields/MessageFields";
import type { Draft } from "./form/draft";
import type { MessageShape } from "./form/shapes";
import { JsonEditor } from "./JsonEditor";
import type { useDraft } from "./useDraft";

type DraftState = ReturnType<typeof useDraft>;

interface ModeSwitchProps {
  state: DraftState;
  /** What it chooses: "Write the goal as". */
  label: string;
  size?: "xs" | "sm";
}

/** Chooses between the form and the JSON of a message. */
export function ModeSwitch({ state, label, size = "sm" }: ModeSwitchProps) {
  return (
    <SegmentedControl
      size={size}
      aria-label={label}
      value={state.draft.mode}
      onChange={(mode) => state.setMode(mode as Draft["mode"])}
      data={[
        { label: "Form", value: "form" },
        { label: "JSON", value: "json" },
      ]}
    />
  );
}

interface DraftFieldsProps {
  state: DraftState;
  shape: MessageShape;
  /** The path of the field to show; null for none. */
  sought: string | null;
  /** The field is shown. It has to stay the same function. */
  onFound: () => void;
  /** What the JSON is called. */
  label?: string;
}

/** The fields of a message, or its JSON. */
export function DraftFields({ state, shape, sought, onFound, label }: DraftFieldsProps) {
  const { draft, errors, change, hidden, message } = state;
  const form: FormContextValue = useMemo(
    () => ({ errors, change, sought, found: onFound }),
    [errors, change, sought, onFound],
  );
  return (
    <FormProvider value={form}>
      {draft.mode === "json" ? (
        <JsonEditor text={draft.text} onChange={state.setText} label={label} hidden={hidden} />
      ) : (
        <MessageFields shape={shape} values={draft.values} path={[]} message={message} />
      )}
    </FormProvider>
  );
}

/** The fields that the gateway has refused, each with the reason; none if the error is about something else. */
export function refusedFields(error: unknown): { path: string; detail: string }[] {
  if (!(error instanceof ClientError)) return [];
  return error.fields.map(({ path, expected, detail }) => ({
    path,
    detail: expected === undefined ? detail : `expected ${expected}, ${detail}`,
  }));
}
