import { PAGES } from "../pages/pages";
import { isTextField } from "../stop/keys";
import { keep, readKept } from "../ui/kept";

/** The second letter has to come this soon. */
export const SECOND_WITHIN_MS = 1500;

export type Asked = { kind: "list" } | { kind: "search" } | { kind: "page"; to: string };

/** Knows what is asked for by letters alone: `?`, `/`, and g with a page's letter. */
export class Letters {
  #g = Number.NEGATIVE_INFINITY;

  /** What this key press asks for; null where it is for somebody else. */
  press(event: KeyboardEvent): Asked | null {
    const since = event.timeStamp - this.#g;
    if (event.key !== "Shift") this.#g = Number.NEGATIVE_INFINITY;
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || isTextField(event.target))
      return null;
    if (event.key === "?") return { kind: "list" };
    if (event.key === "/") return { kind: "search" };
    if (since <= SECOND_WITHIN_MS) {
      const page = PAGES.find(({ letter }) => letter === event.key);
      if (page !== undefined) return { kind: "page", to: page.to };
    }
    if (event.key === "g") this.#g = event.timeStamp;
    return null;
  }
}

const KEY = "dock-gateway-letters";

/** Whether letters alone do something: who speaks to the computer can do without (WCAG 2.1.4). */
export function lettersOn(): boolean {
  return readKept(KEY) !== "off";
}

export function setLettersOn(on: boolean): void {
  keep(KEY, on ? null : "off");
}
