import { Button, Code, VisuallyHidden } from "@mantine/core";
import { useEffect, useState } from "react";
import classes from "./ui.module.css";

type Outcome = "idle" | "copied" | "failed";

const OUTCOMES: Record<Exclude<Outcome, "idle">, string> = { copied: "Copied", failed: "Not copied" };

interface CopyButtonProps {
  value: string;
  /** What that is, to a screen reader. */
  what: string;
  label?: string;
}

/** Copies `value`. */
export function CopyButton({ value, what, label = "Copy" }: CopyButtonProps) {
  const [outcome, setOutcome] = useState<Outcome>("idle");

  useEffect(() => {
    if (outcome === "idle") return;
    const timer = setTimeout(() => setOutcome("idle"), 2000);
    return () => clearTimeout(timer);
  }, [outcome]);

  const copy = async () => setOutcome((await copyText(value)) ? "copied" : "failed");
  return (
    <Button variant="default" size="compact-sm" miw={92} onClick={copy}>
      <span aria-live="polite">{outcome === "idle" ? label : OUTCOMES[outcome]}</span>
      <VisuallyHidden> {what}</VisuallyHidden>
    </Button>
  );
}

/** A line to copy into a terminal. */
export function Command({ line, what }: { line: string; what: string }) {
  return (
    <div className={classes.command}>
      <Code>{line}</Code>
      <CopyButton value={line} what={what} />
    </div>
  );
}

/** Copies text; also on pages over plain http from another machine, where `navigator.clipboard` does not exist. */
async function copyText(text: string): Promise<boolean> {
  try {
    if (navigator.clipboard) {
      await navigator.clipboard.writeText(text);
      return true;
    }
  } catch {
    // The browser refused; the old way may still work.
  }
  const area = document.createElement("textarea");
  area.value = text;
  area.style.position = "fixed";
  area.style.opacity = "0";
  const focused = document.activeElement;
  document.body.append(area);
  area.select();
  try {
    return document.execCommand("copy");
  } catch {
    return false;
  } finally {
    area.remove();
    if (focused instanceof HTMLElement) focused.focus();
  }
}
