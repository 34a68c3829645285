import { Text } from "@mantine/core";
import { useGatewayNow } from "../store/clock";
import { useLive, useTopic } from "../store/context";
import { formatDuration } from "../ui/time";
import { describeVelocity } from "./velocity";

/** Commands older than this are history, not what the robot does. */
const RECENT_MS = 1000;

/** The velocity command that the robot is given. */
export function VelocityLine() {
  const { twist, receivedAt } = useTopic("cmdVel");
  const live = useLive();
  const now = useGatewayNow(500);
  return (
    <Text size="sm" className="tabular" data-testid="velocity">
      <Text span size="sm" c="dimmed">
        Velocity command:
      </Text>{" "}
      {text()}
    </Text>
  );

  function text(): string {
    if (!live) return "not live";
    if (twist === null || receivedAt === null) return "none so far";
    const age = now - receivedAt;
    const words = describeVelocity(twist);
    return age <= RECENT_MS ? words : `none for ${formatDuration(age)} (last: ${words})`;
  }
}
