import { useHotkeys } from "@mantine/hooks";
import { Suspense, useCallback, useEffect, useRef, useState } from "react";
import { useLocation } from "react-router";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";
import { Tool } from "../ui/Tool";

const Palette = lazyPart(() => import("./Palette"));

/** The dialog that opened by a command takes the focus within this time (ms). */
const FOCUS_AFTER_MS = 100;

/** Opens the search, which is loaded on its first use; Ctrl+K does so everywhere. */
export function SearchButton() {
  const [opened, setOpened] = useState(false);
  const [used, setUsed] = useState(false);
  const before = useRef<Element | null>(null);
  const { pathname } = useLocation();

  const open = useCallback(() => {
    before.current = document.activeElement;
    setUsed(true);
    setOpened(true);
  }, []);
  const close = useCallback(() => {
    setOpened(false);
    setTimeout(() => {
      const { activeElement } = document;
      if (activeElement !== null && activeElement !== document.body) return;
      if (before.current instanceof HTMLElement) before.current.focus();
    }, FOCUS_AFTER_MS);
  }, []);
  useHotkeys([["mod+K", () => (opened ? close() : open())]], [], true);

  // Also before it is loaded.
  useEffect(() => {
    if (!opened) return;
    const hear = ({ key }: KeyboardEvent) => key === "Escape" && close();
    window.addEventListener("keydown", hear, true);
    return () => window.removeEventListener("keydown", hear, true);
  }, [opened, close]);

  return (
    <>
      <Tool
        name="Search and commands"
        path="M10 2a8 8 0 0 1 6.3 12.9l5.4 5.4-1.4 1.4-5.4-5.4A8 8 0 1 1 10 2Zm0 2a6 6 0 1 0 0 12 6 6 0 0 0 0-12Z"
        visibleFrom="xs"
        title="Search and commands (Ctrl+K)"
        aria-haspopup="dialog"
        aria-keyshortcuts="Control+K Meta+K"
        onClick={open}
      />
      {used && (
        <Guarded of={pathname}>
          <Suspense fallback={null}>
            <Palette opened={opened} onClose={close} />
          </Suspense>
        </Guarded>
      )}
    </>
  );
}
