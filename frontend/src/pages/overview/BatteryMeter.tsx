import { VisuallyHidden } from "@mantine/core";
import { memo } from "react";
import type { Robot } from "../../api/types";
import { type Charge, ChargeBar, chargeOf } from "../../battery/ChargeBar";
import { CHARGING, FULL, formatQuantity, statusWords } from "../../battery/words";
import { useAtTime } from "../../clock/clock";
import { useFleetLive } from "../../fleet/context";
import { ageWords } from "../../fleet/words";
import { believed } from "../../store/believed";
import { freshnessOf } from "../../store/freshness";
import classes from "./overview.module.css";

/** A robot's battery: how full, whether it charges, and how old that is. */
export function BatteryMeter({ battery, charging }: Pick<Robot, "battery" | "charging">) {
  const { state, received_at, stale_after_s, low_below } = battery;
  if (state === null || received_at === null) return <span className={classes.empty}>No data</span>;
  const known = believed({ ...battery, state });
  const { percentage, voltage, power_supply_status: status } = known;
  const filled = percentage === null ? null : Math.round(percentage * 100);
  return (
    <div className={classes.battery}>
      <Level
        text={filled === null ? formatQuantity(voltage, "V") : `${filled} %`}
        filled={filled === null ? null : Math.min(100, Math.max(0, filled))}
        charge={chargeOf(known, low_below, charging)}
        status={charging && status === 0 ? CHARGING : status}
      />
      <Age receivedAt={Date.parse(received_at)} staleAfterMs={stale_after_s * 1000} />
    </div>
  );
}

interface LevelProps {
  text: string;
  /** In percent; null where it is not measured. */
  filled: number | null;
  charge: Charge;
  status: number;
}

/** Changes only where what is shown does: messages come often. */
const Level = memo(function Level({ text, filled, charge, status }: LevelProps) {
  const charging = status === CHARGING;
  return (
    <div className={classes.level}>
      <ChargeBar filled={filled} charge={charge} />
      <span className={classes.percentage}>{text}</span>
      {charging && <Bolt />}
      <span className={classes.status}>
        {status === FULL && "full"}
        <VisuallyHidden>{status === FULL ? "" : statusWords(status).toLowerCase()}</VisuallyHidden>
        {charge === "low" && "low"}
      </span>
    </div>
  );
});

function Bolt() {
  return (
    <svg
      className={classes.bolt}
      width="14"
      height="16"
      viewBox="0 0 14 16"
      aria-hidden="true"
      fill="currentColor"
    >
      <title>Charging</title>
      <path d="M8.5 0 1 9h4.5L4.5 16 13 6H8.2L8.5 0Z" />
    </svg>
  );
}

function Age({ receivedAt, staleAfterMs }: { receivedAt: number; staleAfterMs: number }) {
  const words = useAtTime((now) => ageWords(now - receivedAt));
  const live = useFleetLive();
  const stale = useAtTime((now) => freshnessOf(live, now - receivedAt, staleAfterMs) === "stale");
  return (
    <span className={classes.age} data-stale={stale || undefined}>
      {stale ? `stale: ${words}` : words}
    </span>
  );
}
