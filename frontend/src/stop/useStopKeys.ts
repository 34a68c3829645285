import { useHotkeys } from "@mantine/hooks";
import { useEffect } from "react";
import { CHORD, DoubleEscape } from "./keys";

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
