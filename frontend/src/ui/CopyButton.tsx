import { Button, VisuallyHidden } from "@mantine/core";
import { useEffect, useState } from "react";
import { copyText } from "./copyText";

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
