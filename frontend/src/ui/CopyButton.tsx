import { Button, VisuallyHidden } from "@mantine/core";
import { useEffect, useState } from "react";
import { copyText } from "./copyText";

type Outcome = "idle" | "copied" | "failed";

const LABELS: Record<Outcome, string> = { idle: "Copy", copied: "Copied", failed: "Not copied" };

/** Copies `value`; `what` says to a screen reader what that is. */
export function CopyButton({ value, what }: { value: string; what: string }) {
  const [outcome, setOutcome] = useState<Outcome>("idle");

  useEffect(() => {
    if (outcome === "idle") return;
    const timer = setTimeout(() => setOutcome("idle"), 2000);
    return () => clearTimeout(timer);
  }, [outcome]);

  const copy = async () => setOutcome((await copyText(value)) ? "copied" : "failed");
  return (
    <Button variant="default" size="compact-sm" miw={92} onClick={copy}>
      <span aria-live="polite">{LABELS[outcome]}</span>
      <VisuallyHidden> {what}</VisuallyHidden>
    </Button>
  );
}
