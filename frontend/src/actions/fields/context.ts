import { createContext, useContext, useEffect, useRef } from "react";
import { errorsAt, errorsIn } from "../form/draft";
import { dotted, type Path, type Value } from "../form/shapes";
import type { FieldError } from "../form/write";

/** What every field of a form needs of it. */
export interface FormContextValue {
  errors: readonly FieldError[];
  change(path: Path, value: Value): void;
  /** The path of a field to show and to focus; null where there is none. */
  sought: string | null;
  found(): void;
}

const FormContext = createContext<FormContextValue | null>(null);

export const FormProvider = FormContext.Provider;

export function useForm(): FormContextValue {
  const form = useContext(FormContext);
  if (form === null) throw new Error("FormProvider is missing");
  return form;
}

/** Descriptions are of all lengths: below the inputs they leave those of a row beside each other. */
export const ORDER: ("label" | "input" | "error" | "description")[] = [
  "label",
  "input",
  "error",
  "description",
];

/** What the inputs of a form have in common. */
export interface InputProps<V extends Value> {
  path: Path;
  label: string;
  description: string | null;
  unit: string | null;
  value: V;
  /** Whether its value is unknown when it is left empty. */
  optional: boolean;
}

/**
 * What is wrong at a path, how to change what is there, and a ref of what to focus when that is sought.
 *
 * @param parts Whether what is within it belongs to this field, too; false where that has fields of its own.
 */
export function useField<Element extends HTMLElement>(path: Path, parts = true) {
  const { errors, change, sought, found } = useForm();
  const where = dotted(path);
  const wrong = parts ? errorsIn(errors, where) : errorsAt(errors, where);
  const ref = useRef<Element>(null);
  const isSought = sought === where || (parts && sought?.startsWith(`${where}.`) === true);

  useEffect(() => {
    if (!isSought) return;
    ref.current?.focus();
    found();
  }, [isSought, found]);

  return {
    ref,
    error: wrong.length > 0 ? wrong.map(({ detail }) => detail).join("; ") : undefined,
    set: (value: Value) => change(path, value),
  };
}
