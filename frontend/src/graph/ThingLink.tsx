import classes from "./graph.module.css";
import { type Thing, thingId } from "./things";
import type { ChangeView } from "./useView";

interface ThingLinkProps extends Thing {
  change: ChangeView;
  current?: boolean;
}

/** The name of a thing, which shows its details. */
export function ThingLink({ kind, name, change, current = false }: ThingLinkProps) {
  return (
    <button
      type="button"
      className={classes.link}
      aria-current={current || undefined}
      data-thing={thingId({ kind, name })}
      onClick={() => change({ selected: { kind, name } })}
    >
      {name}
    </button>
  );
}
