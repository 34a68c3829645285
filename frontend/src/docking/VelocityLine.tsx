import { Text } from "@mantine/core";
import type { Twist } from "../api/types";
import { useAtTime } from "../clock/clock";
import { useServices } from "../store/context";
import { type Freshness, useFreshness } from "../store/freshness";
import { RENDER_INTERVAL_MS } from "../store/shown";
import type { CmdVel } from "../store/state";
import { formatDuration } from "../ui/time";

/** The velocity command that the robot is given. */
export function VelocityLine() {
  return (
    <Text size="sm" className="tabular" data-testid="velocity">
      <Text span size="sm" c="dimmed">
        Velocity command:
      </Text>{" "}
      <Words />
    </Text>
  );
}

function Words() {
  const { store } = useServices();
  const freshness = useFreshness("velocity");
  return useAtTime((now) => velocityWords(store.get("cmdVel"), freshness, now), RENDER_INTERVAL_MS);
}

function velocityWords({ twist, receivedAt }: CmdVel, freshness: Freshness, now: number): string {
  if (freshness === "offline") return "not live";
  if (twist === null || receivedAt === null) return "none so far";
  const words = describeVelocity(twist);
  return freshness === "live" ? words : `none for ${formatDuration(now - receivedAt)} (last: ${words})`;
}

const number = new Intl.NumberFormat(undefined, { maximumFractionDigits: 3 });

/** A velocity command in words: `forward 0.10 m/s, turning left 0.15 rad/s`. */
export function describeVelocity(twist: Twist): string {
  const parts: string[] = [];
  const { x, y } = twist.linear;
  const turn = twist.angular.z;
  if (x === null || y === null || turn === null) return "not a number";
  if (x !== 0) parts.push(`${x > 0 ? "forward" : "backward"} ${number.format(Math.abs(x))} m/s`);
  if (y !== 0) parts.push(`${y > 0 ? "left" : "right"} ${number.format(Math.abs(y))} m/s`);
  if (turn !== 0) parts.push(`turning ${turn > 0 ? "left" : "right"} ${number.format(Math.abs(turn))} rad/s`);
  return parts.length === 0 ? "standing still" : parts.join(", ");
}
