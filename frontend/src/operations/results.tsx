import { Button, Group, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { useMemo } from "react";
import { useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import type { Naming } from "../fleet/names";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { divide, OPERATION_NAMES, type Operation, type Refusal } from "./operation";
import classes from "./operations.module.css";

/** What has become of an operation on robots so far. */
interface Results {
  operation: Operation;
  /** How many robots there are in all. */
  count: number;
  /** The robots that accepted it. */
  sent: readonly string[];
  refused: readonly Refusal[];
}

let serial = 0;

/** A notice about one operation, which says more as robots answer. */
export class ResultsNotice {
  readonly #id: string;
  readonly #naming: Naming;

  constructor(naming: Naming, results: Results) {
    serial += 1;
    this.#id = `operation ${serial}`;
    this.#naming = naming;
    notifications.show({ ...this.#describe(results), id: this.#id });
  }

  update(results: Results): void {
    notifications.update({ ...this.#describe(results), id: this.#id });
  }

  #describe(results: Results) {
    const { count, sent, refused } = results;
    const loading = sent.length + refused.length < count;
    const good = refused.length === 0;
    return {
      // Read out without interrupting what is being read.
      role: "status",
      color: good ? "green" : "orange",
      title: this.#title(results, loading),
      message: <List naming={this.#naming} results={results} />,
      loading,
      withCloseButton: !loading,
      closeButtonProps: { "aria-label": "Dismiss" },
      autoClose: loading || !good ? (false as const) : 6000,
    };
  }

  #title({ operation, count, sent, refused }: Results, loading: boolean): string {
    const name = OPERATION_NAMES[operation];
    const [only] = [...sent, ...refused.map((each) => each.name)];
    if (loading)
      return count === 1
        ? `${name}: waiting for the answer`
        : `${name}: ${sent.length + refused.length} of ${count} robots answered`;
    if (count === 1 && only !== undefined)
      return `${name}: ${this.#naming.fullNameOf(only)} ${sent.length === 1 ? "accepted" : "did not accept"}`;
    return refused.length === 0
      ? `${name}: all ${count} robots accepted`
      : `${name}: ${sent.length} of ${count} robots accepted`;
  }
}

function List({ naming, results: { count, sent, refused } }: { naming: Naming; results: Results }) {
  return (
    <div className={classes.results}>
      <RefusalList naming={naming} refused={refused} named={count > 1} />
      {count > 1 && sent.length > 0 && (
        <div>Accepted: {sent.map((name) => naming.nameOf(name)).join(", ")}</div>
      )}
    </div>
  );
}

interface RefusalListProps {
  naming: Naming;
  refused: readonly Refusal[];
  /** Whether the robots are named: it is not needed where there is a single one. */
  named?: boolean;
}

/** The robots that something cannot be done to, and why; those with the same reason together. */
function RefusalList({ naming, refused, named = true }: RefusalListProps) {
  const byReason = new Map<string, string[]>();
  for (const { name, reason } of refused) {
    const names = byReason.get(reason) ?? [];
    byReason.set(reason, [...names, naming.nameOf(name)]);
  }
  return (
    <ul className={classes.refusals}>
      {[...byReason].map(([reason, names]) => (
        <li key={reason}>
          {reason}
          {named && <strong> {names.join(", ")}</strong>}
        </li>
      ))}
    </ul>
  );
}

const WHAT_HAPPENS: Record<Operation, string> = {
  dock: "They drive to their docks by themselves. Check first that their area is clear.",
  undock: "They back out of their docks by themselves. Check first that the area behind them is clear.",
  cancel: "Their goals are canceled, and they stand still.",
  stop: "",
};

interface ManyDialogProps {
  operation: Operation;
  /** The robots' names. */
  names: readonly string[];
  opened: boolean;
  onGo: (able: readonly string[]) => void;
  onClose: () => void;
}

/** Asks before something is done to several robots: names them, and says which ones it cannot be done to. */
export function ManyDialog({ operation, names, opened, onGo, onClose }: ManyDialogProps) {
  const robots = useFleetTopic("robots");
  const live = useFleetLive();
  const naming = useNaming();
  const { able, unable } = useMemo(() => {
    const known = names.flatMap((name) => robots.get(name) ?? []);
    const { able, unable } = divide(operation, known, live);
    const gone = names.filter((name) => !robots.has(name));
    return {
      able,
      unable: [...unable, ...gone.map((name) => ({ name, reason: "It has left the ROS graph." }))],
    };
  }, [operation, names, robots, live]);
  const name = OPERATION_NAMES[operation];
  const count = able.length === 1 ? "1 robot" : `${able.length} robots`;
  return (
    <Dialog opened={opened} onClose={onClose} title={`${name} ${count}?`}>
      <Stack gap="md">
        {able.length > 0 && (
          <>
            <Text fw={600} className={classes.names ?? ""} tabIndex={0}>
              {able.map((robot) => naming.fullNameOf(robot.name)).join(", ")}
            </Text>
            <Text size="sm">{WHAT_HAPPENS[operation]}</Text>
          </>
        )}
        {unable.length > 0 && (
          <section aria-label="Left out">
            <Text size="sm">
              Left out: {unable.length} of {names.length} robots
            </Text>
            <Text component="div" size="sm" className={classes.names ?? ""} tabIndex={0}>
              <RefusalList naming={naming} refused={unable} />
            </Text>
          </section>
        )}
        <Group justify="flex-end" gap="sm">
          <Button variant="default" onClick={onClose} data-autofocus>
            {operation === "cancel" ? "Let them go on" : "Leave them there"}
          </Button>
          <ReasonButton
            reason={able.length === 0 ? "None of the robots can do this now." : null}
            onClick={() => onGo(able.map((robot) => robot.name))}
          >
            {name} {count}
          </ReasonButton>
        </Group>
      </Stack>
    </Dialog>
  );
}
