import { Button, Checkbox, Code, Group, Stack, Text } from "@mantine/core";
import { useLocalStorage } from "@mantine/hooks";
import { useId, useState } from "react";
import { useNaming } from "../fleet/context";
import { Dialog } from "../ui/Dialog";
import classes from "./actions.module.css";

interface SendDialogProps {
  action: string;
  /** What is sent. */
  body: string;
  /** Why it cannot be sent any more; null where it can. */
  reason: string | null;
  opened: boolean;
  onClose: () => void;
  /** @param unasked Whether nobody wants to be asked again. */
  onSend: (unasked: boolean) => void;
}

/** Asks before a goal is sent that may move a robot. */
export function SendDialog({ opened, ...question }: SendDialogProps) {
  return (
    <Dialog opened={opened} onClose={question.onClose} title="Send this goal?">
      <Question {...question} />
    </Dialog>
  );
}

function Question({ action, body, reason, onClose, onSend }: Omit<SendDialogProps, "opened">) {
  const [unasked, setUnasked] = useState(false);
  const reasonId = useId();
  const robot = useNaming().ownerNameOf(action) ?? "a robot";
  return (
    <Stack gap="md">
      <Text size="sm">
        <strong className={classes.name}>{action}</strong> may move {robot}. Check first that the area is
        clear.
      </Text>
      <Code block className={classes.body} tabIndex={0} role="region" aria-label="What is sent">
        {body}
      </Code>
      <Checkbox
        label="Do not ask again for this action in this browser"
        checked={unasked}
        onChange={(event) => setUnasked(event.currentTarget.checked)}
      />
      <Group justify="flex-end" gap="sm">
        <Button variant="default" onClick={onClose} data-autofocus>
          Do not send
        </Button>
        <Button disabled={reason !== null} aria-describedby={reasonId} onClick={() => onSend(unasked)}>
          Send the goal
        </Button>
      </Group>
    </Stack>
  );
}

const KEY = "dock-gateway-unasked-actions";

export interface Asking {
  /** Whether it is asked before a goal is sent. */
  asks: boolean;
  /** Goals of this type move nothing, so that it is never asked: Fibonacci only counts. */
  harmless: boolean;
  change: (asks: boolean) => void;
}

/** Whether to ask before a goal is sent to an action: until somebody switches that off for it, in this browser. */
export function useAsking(action: string, type: string): Asking {
  const [unasked, setUnasked] = useLocalStorage<readonly string[]>({
    key: KEY,
    defaultValue: [],
    getInitialValueInEffect: false,
  });
  const harmless = type.endsWith("/action/Fibonacci");
  return {
    asks: !harmless && !unasked.includes(action),
    harmless,
    change: (asks) =>
      setUnasked((before) => [...before.filter((each) => each !== action), ...(asks ? [] : [action])]),
  };
}
