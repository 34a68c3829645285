import { Button, type ButtonProps, Tooltip } from "@mantine/core";
import { type ComponentProps, useId } from "react";

type NativeProps = Omit<ComponentProps<"button">, keyof ButtonProps>;

interface ReasonButtonProps extends Omit<ButtonProps, "disabled">, NativeProps {
  /** Why it cannot be used now; null where it can. */
  reason: string | null;
}

/** The look of a button next to an entry of a list. */
export const ENTRY_BUTTON = { variant: "default", size: "compact-sm" } as const;

/**
 * A button that says in a tooltip why it cannot be used. Then it can still have the focus, so that the reason is there for
 * the keyboard, a finger and a screen reader, too.
 */
export function ReasonButton({ reason, onClick, type = "button", ...button }: ReasonButtonProps) {
  const id = useId();
  const disabled = reason !== null;
  return (
    <>
      <Tooltip label={reason} disabled={!disabled} multiline maw={300}>
        <DescribedButton
          {...button}
          describedBy={disabled ? id : undefined}
          data-disabled={disabled || undefined}
          aria-disabled={disabled || undefined}
          type={disabled ? "button" : type}
          onClick={disabled ? undefined : onClick}
        />
      </Tooltip>
      <span id={id} hidden>
        {reason}
      </span>
    </>
  );
}

interface DescribedButtonProps extends ButtonProps, NativeProps {
  describedBy: string | undefined;
}

/** A tooltip describes its button only while it is open; this one is described always. */
function DescribedButton({ describedBy, ...button }: DescribedButtonProps) {
  return <Button {...button} aria-describedby={describedBy} />;
}
