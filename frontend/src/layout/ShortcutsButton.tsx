import { Suspense, useEffect, useState } from "react";
import { useLocation, useNavigate } from "react-router";
import { useMenu } from "../pages/pages";
import { isTextField } from "../stop/keys";
import { Dialog } from "../ui/Dialog";
import { Guarded } from "../ui/Guarded";
import { keep, readKept } from "../ui/kept";
import { lazyPart } from "../ui/lazyPart";
import { Tool } from "../ui/Tool";

const ShortcutList = lazyPart(() => import("./ShortcutList"));

/** What the keyboard does, in a list that ? opens, and the name that others read when this page stops a robot. */
export function ShortcutsButton() {
  const [opened, setOpened] = useState(false);
  useLetters(() => setOpened(true));
  const { pathname } = useLocation();
  // biome-ignore lint/correctness/useExhaustiveDependencies: another page closes it
  useEffect(() => setOpened(false), [pathname]);
  return (
    <>
      <Tool
        name="Keyboard and name"
        title="Keyboard and name (?)"
        pixels={20}
        path="M4 5h16a2 2 0 0 1 2 2v10a2 2 0 0 1-2 2H4a2 2 0 0 1-2-2V7a2 2 0 0 1 2-2Zm0 2v10h16V7H4Zm1.5 1.5h2v2h-2v-2Zm3.7 0h2v2h-2v-2Zm3.6 0h2v2h-2v-2Zm3.7 0h2v2h-2v-2Zm-11 4h2v2h-2v-2Zm3.7 0h5.6v2H9.2v-2Zm7.3 0h2v2h-2v-2Z"
        aria-haspopup="dialog"
        onClick={() => setOpened(true)}
      />
      <Dialog opened={opened} onClose={() => setOpened(false)} title="Keyboard and name">
        <Guarded of={pathname}>
          <Suspense fallback={null}>
            <ShortcutList />
          </Suspense>
        </Guarded>
      </Dialog>
    </>
  );
}

/** Does what letters ask for, but in dialogs. */
function useLetters(openList: () => void): void {
  const navigate = useNavigate();
  const menu = useMenu();
  useEffect(() => {
    const letters = new Letters(menu);
    const hear = (event: KeyboardEvent) => {
      if (!lettersOn() || document.querySelector("[aria-modal=true]") !== null) return;
      const asked = letters.press(event);
      if (asked === null) return;
      event.preventDefault();
      if (asked.kind === "list") openList();
      else if (asked.kind === "search")
        document.querySelector<HTMLInputElement>("main input[type=search]")?.focus();
      else void navigate(asked.to);
    };
    window.addEventListener("keydown", hear);
    return () => window.removeEventListener("keydown", hear);
  });
}

/** The second letter has to come this soon. */
export const SECOND_WITHIN_MS = 1500;

type Asked = { kind: "list" } | { kind: "search" } | { kind: "page"; to: string };

/** Knows what is asked for by letters alone: `?`, `/`, and g with a page's letter. */
export class Letters {
  #g = Number.NEGATIVE_INFINITY;

  constructor(private readonly pages: readonly { letter: string; to: string }[]) {}

  /** What this key press asks for; null where it is for somebody else. */
  press(event: KeyboardEvent): Asked | null {
    const since = event.timeStamp - this.#g;
    if (event.key !== "Shift") this.#g = Number.NEGATIVE_INFINITY;
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || isTextField(event.target))
      return null;
    if (event.key === "?") return { kind: "list" };
    if (event.key === "/") return { kind: "search" };
    if (since <= SECOND_WITHIN_MS) {
      const page = this.pages.find(({ letter }) => letter === event.key);
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
