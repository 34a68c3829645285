import { createContext, useContext } from "react";
import type { Path, Value } from "../form/values";
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
  /** Whether nobody knows what it is when it is left empty. */
  optional: boolean;
}
