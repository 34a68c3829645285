import { useHotkeys } from "@mantine/hooks";
import { useEffect } from "react";

/** Two presses of Escape that are this close are meant. */
export const TWICE_WITHIN_MS = 700;

/** Works everywhere, also while somebody types. */
const CHORD = "ctrl+shift+X";

/**
 * Recognizes two presses of Escape in quick succession, also in a text field. While an input method composes text, Escape
 * belongs to the input method.
 */
export class DoubleEscape {
  #last = Number.NEGATIVE_INFINITY;

  /** Whether this key press is the second of two. */
  press(event: KeyboardEvent): boolean {
    const modified = event.ctrlKey || event.altKey || event.metaKey || event.shiftKey;
    if (event.key !== "Escape" || modified || event.isComposing) {
      this.#last = Number.NEGATIVE_INFINITY;
      return false;
    }
    // A key that is held down repeats.
    if (event.repeat) return false;
    const since = event.timeStamp - this.#last;
    const twice = since >= 0 && since <= TWICE_WITHIN_MS;
    this.#last = twice ? Number.NEGATIVE_INFINITY : event.timeStamp;
    return twice;
  }
}

const NO_TEXT = new Set([
  "button",
  "checkbox",
  "color",
  "file",
  "image",
  "radio",
  "range",
  "reset",
  "submit",
]);

/** Whether keys are text there. */
export function isTextField(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return !NO_TEXT.has(target.type);
  return (
    target instanceof HTMLTextAreaElement ||
    target instanceof HTMLSelectElement ||
    (target instanceof HTMLElement && target.isContentEditable)
  );
}

/** One for all pages: the first Escape may lead from one to another. */
const twice = new DoubleEscape();

/** Calls `stop` at Escape twice and at the chord, whatever has the focus. */
export function useStopKeys(stop: () => void): void {
  useHotkeys([[CHORD, stop]], [], true);
  useEffect(() => {
    const hear = (event: KeyboardEvent) => {
      if (twice.press(event)) stop();
    };
    // Before anything that Escape closes can keep the key to itself.
    window.addEventListener("keydown", hear, true);
    return () => window.removeEventListener("keydown", hear, true);
  }, [stop]);
}
