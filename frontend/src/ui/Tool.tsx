import { ActionIcon } from "@mantine/core";
import type { ReactNode } from "react";

interface ToolProps {
  /** What it does, in a word. */
  name: string;
  disabled?: boolean;
  /** Why it is disabled. */
  why?: string;
  /** For one that switches something on and off: whether it is on. */
  pressed?: boolean;
  onClick: () => void;
  /** The picture's paths, on 24 by 24. */
  children: ReactNode;
}

/** A small button with a picture on it. */
export function Tool({ name, disabled = false, why, pressed, onClick, children }: ToolProps) {
  return (
    <ActionIcon
      variant={pressed ? "filled" : "default"}
      size="lg"
      aria-label={name}
      aria-pressed={pressed}
      title={disabled ? why : name}
      disabled={disabled}
      onClick={onClick}
    >
      <svg width="18" height="18" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
        {children}
      </svg>
    </ActionIcon>
  );
}
