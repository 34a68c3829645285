import { notifications } from "@mantine/notifications";
import type { Naming } from "../fleet/names";
import { OPERATION_NAMES, type Operation, type Refusal } from "./operation";
import classes from "./operations.module.css";

/** What has become of an operation on robots so far. */
export interface Results {
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
export function RefusalList({ naming, refused, named = true }: RefusalListProps) {
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
