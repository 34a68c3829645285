import { Text } from "@mantine/core";
import { useAtTime } from "../store/clock";
import { useLive, useServices } from "../store/context";
import { RENDER_INTERVAL_MS } from "../store/shown";
import type { CmdVel } from "../store/state";
import { formatDuration } from "../ui/time";
import { describeVelocity } from "./velocity";

/** Commands older than this are history, not what the robot does. */
const RECENT_MS = 1000;

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
  const live = useLive();
  const words = useAtTime((now) => velocityWords(store.get("cmdVel"), now), RENDER_INTERVAL_MS);
  return live ? words : "not live";
}

function velocityWords({ twist, receivedAt }: CmdVel, now: number): string {
  if (twist === null || receivedAt === null) return "none so far";
  const age = now - receivedAt;
  const words = describeVelocity(twist);
  return age <= RECENT_MS ? words : `none for ${formatDuration(age)} (last: ${words})`;
}
