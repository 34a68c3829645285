import type { Robot } from "@dock-gateway/client";
import { Badge } from "@mantine/core";
import { memo } from "react";
import { SeverityMark } from "../../alerts/marks";
import type { Attention } from "../../alerts/order";
import { ChargeBar, chargeOf } from "../../battery/BatteryCard";
import { formatPercentage, formatQuantity } from "../../battery/words";
import { useAtTime } from "../../clock/clock";
import { robotName } from "../../fleet/names";
import { LINK_WORDS, linkOf, placeWords } from "../../fleet/words";
import { runningWords, soFarWords } from "../../goal/words";
import { believed } from "../../store/batterySeries";
import { freshnessOf } from "../../store/context";
import { siteOf } from "../overview/list";
import classes from "./wall.module.css";

interface TileProps {
  robot: Robot;
  attention: Attention;
  live: boolean;
}

/** A robot, to be read from a distance. Only what is wrong has a colour. */
export const Tile = memo(function Tile({ robot, attention, live }: TileProps) {
  const [goal] = robot.goals;
  const { latched, by } = robot.stop;
  const link = linkOf(robot);
  const site = siteOf(robot);
  return (
    <li
      className={classes.tile}
      data-testid={`tile ${robot.name}`}
      data-away={link === "away" || undefined}
      data-attention={attention === 3 ? "critical" : attention === 2 ? "warning" : undefined}
    >
      <div className={classes.name}>
        {attention >= 2 && <SeverityMark mark={attention === 3 ? "critical" : "warning"} />}
        <h2 title={robotName(robot)}>{robotName(robot)}</h2>
      </div>
      <div className={classes.place}>
        {placeWords(robot.docked)}
        {site !== "" && `, ${site}`}
      </div>
      <Battery battery={robot.battery} charging={robot.charging} live={live} />
      <div className={classes.now}>
        {latched ? (
          <Badge
            color="red"
            className={classes.badge ?? ""}
            title={by === null ? undefined : `Stopped by ${by}`}
          >
            Stopped{by !== null && ` by ${by}`}
          </Badge>
        ) : link === "away" ? (
          <span className={classes.wrong}>{LINK_WORDS[link]}</span>
        ) : goal !== undefined ? (
          <>
            <span className={classes.goal}>{runningWords(goal)}</span>
            {live && <Elapsed since={Date.parse(goal.created_at)} />}
          </>
        ) : link === "connected" || link === "battery" ? (
          "Idle"
        ) : (
          <span className={classes.wrong}>{LINK_WORDS[link]}</span>
        )}
      </div>
    </li>
  );
});

function Battery({ battery, charging, live }: Pick<Robot, "battery" | "charging"> & { live: boolean }) {
  const { received_at, stale_after_s, low_below } = battery;
  const stale = useAtTime(
    (now) =>
      received_at !== null &&
      freshnessOf(live, now - Date.parse(received_at), stale_after_s * 1000) === "stale",
  );
  const known = believed(battery);
  if (known === null) return <div className={classes.battery}>No battery data</div>;
  const { percentage, voltage } = known;
  const filled = percentage === null ? null : Math.min(100, Math.max(0, Math.round(percentage * 100)));
  const charge = chargeOf(known, low_below, charging);
  return (
    <div className={classes.battery}>
      <ChargeBar filled={filled} charge={charge} old={stale} />
      <span>{percentage === null ? formatQuantity(voltage, "V") : formatPercentage(percentage)}</span>
      {stale ? (
        <span className={classes.wrong}>stale</span>
      ) : charge === "low" ? (
        <span className={classes.wrong}>low</span>
      ) : (
        charge === "charging" && <span>charging</span>
      )}
    </div>
  );
}

function Elapsed({ since }: { since: number }) {
  return <span className={classes.elapsed}>{useAtTime((now) => soFarWords(since, now))}</span>;
}

/** A tile that is smaller cannot be read from a distance (px). */
const LEAST_WIDTH = 220;

const LEAST_HEIGHT = 120;

/** The ratio of width to height at which a tile looks best. */
const SHAPE = 1.9;

interface Grid {
  columns: number;
  rows: number;
  pages: number;
}

/** The grid with the largest tiles for `count` robots; several pages where they would be too small on one. */
export function gridFor(count: number, width: number, height: number): Grid {
  const most = Math.max(1, Math.floor(width / LEAST_WIDTH)) * Math.max(1, Math.floor(height / LEAST_HEIGHT));
  const pages = Math.max(1, Math.ceil(count / most));
  const each = Math.max(1, Math.ceil(count / pages));
  let best = { columns: 1, rows: each };
  let largest = 0;
  for (let columns = 1; columns <= each; columns += 1) {
    const rows = Math.ceil(each / columns);
    const [tileWidth, tileHeight] = [width / columns, height / rows];
    const readable = tileWidth >= LEAST_WIDTH && tileHeight >= LEAST_HEIGHT;
    const size = Math.min(tileWidth / SHAPE, tileHeight) * (readable ? 1 : 0.01);
    if (size > largest) {
      largest = size;
      best = { columns, rows };
    }
  }
  return { ...best, pages };
}
