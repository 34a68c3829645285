import { Text } from "@mantine/core";
import { useAtTime } from "../clock/clock";
import { useServices } from "../store/context";
import { type Freshness, useFreshness } from "../store/freshness";
import { RENDER_INTERVAL_MS } from "../store/shown";
import type { CmdVel } from "../store/state";
import { formatDuration } from "../ui/time";
import { describeVelocity } from "./velocity";

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
