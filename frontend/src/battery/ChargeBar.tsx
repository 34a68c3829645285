import classes from "./battery.module.css";
import { CHARGING, FULL, isLow } from "./words";

export type Charge = "charging" | "low" | "ok";

/**
 * What the colour of a battery's bar says.
 *
 * @param charging What the gateway knows beyond the status; null where that is nothing.
 */
export function chargeOf(
  state: { percentage: number | null; power_supply_status: number },
  lowBelow: number,
  charging: boolean | null = null,
): Charge {
  const status = state.power_supply_status;
  if (charging || status === CHARGING || status === FULL) return "charging";
  return isLow(state, lowBelow) ? "low" : "ok";
}

interface ChargeBarProps {
  /** In percent; null where it is not measured. */
  filled: number | null;
  charge: Charge;
  /** It is not how the battery is now. */
  old?: boolean;
}

/** How full a battery is. Its words are beside it. */
export function ChargeBar({ filled, charge, old = false }: ChargeBarProps) {
  return (
    <span className={classes.bar} data-charge={charge} data-old={old || undefined} aria-hidden="true">
      {filled !== null && <span style={{ inlineSize: `${filled}%` }} />}
    </span>
  );
}
