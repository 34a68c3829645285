import { useEffect, useRef } from "react";
import { errorsAt, errorsIn } from "../form/draft";
import { dotted, type Path, type Value } from "../form/values";
import { useForm } from "./context";

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
