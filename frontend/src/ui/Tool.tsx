import { ActionIcon, type ActionIconProps } from "@mantine/core";
import type { ComponentProps } from "react";

interface ToolProps extends ActionIconProps, Omit<ComponentProps<"button">, keyof ActionIconProps | "name"> {
  /** What it does, in a word. */
  name: string;
  /** The picture, on 24 by 24. */
  path: string;
  /** The width and height of the picture (px). */
  pixels?: number;
  /** For one that switches something on and off: whether it is on. */
  pressed?: boolean;
}

/** A small button with a picture on it. */
export function Tool({ name, path, pixels, pressed, title = name, ...button }: ToolProps) {
  return (
    <ActionIcon
      variant={pressed ? "filled" : "default"}
      size="lg"
      aria-label={name}
      aria-pressed={pressed}
      title={title}
      {...button}
    >
      <Icon path={path} pixels={pixels} />
    </ActionIcon>
  );
}

/** A picture on 24 by 24, in the color of the text; the text next to it says what it means. */
export function Icon({ path, pixels = 18 }: { path: string; pixels?: number | undefined }) {
  return (
    <svg width={pixels} height={pixels} viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
      <path d={path} />
    </svg>
  );
}
