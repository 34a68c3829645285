import { Badge, Group, Text } from "@mantine/core";
import type { Publisher } from "../api/types";
import { useGatewayNow } from "../store/clock";
import { useLive, useTopic } from "../store/context";
import { Time } from "../ui/Time";
import { summarize } from "./words";

/** A battery message this fresh means that someone publishes now. */
const FRESH_MS = 3000;
/** A message that comes within this time of the gateway's own publishing is its own. */
const OURS_MS = 1500;

/** What the gateway publishes now, or who else does. */
export function PublisherStatus({ publishedOnceAt }: { publishedOnceAt: number | null }) {
  const publisher = useTopic("publisher");
  const live = useLive();
  if (!live) return <Text size="sm">What is being published is not known while disconnected.</Text>;
  if (publisher?.active) return <Active publisher={publisher} />;
  return <Inactive publishedOnceAt={publishedOnceAt} />;
}

function Active({ publisher }: { publisher: Publisher }) {
  return (
    <Group gap="xs" data-testid="publisher-status">
      <Badge color="green">publishing</Badge>
      <Text size="sm" className="tabular">
        This gateway publishes {publisher.state === null ? "a state" : summarize(publisher.state)} at{" "}
        {publisher.rate_hz} Hz: {publisher.published_count}{" "}
        {publisher.published_count === 1 ? "message" : "messages"}
        {publisher.started_at !== null && (
          <>
            {" "}
            since <Time value={publisher.started_at} />
          </>
        )}
        .
      </Text>
    </Group>
  );
}

function Inactive({ publishedOnceAt }: { publishedOnceAt: number | null }) {
  const { receivedAt } = useTopic("battery");
  const toldAt = useTopic("publisherToldAt");
  const simulated = useTopic("simulator")?.battery_publisher === "self";
  const now = useGatewayNow(500);
  const oursUntil = Math.max(toldAt, publishedOnceAt ?? 0) + OURS_MS;
  const someoneElse = receivedAt !== null && now - receivedAt < FRESH_MS && receivedAt > oursUntil;
  return (
    <Group gap="xs" data-testid="publisher-status">
      <Badge color="gray.7">not publishing</Badge>
      <Text size="sm">
        {simulated
          ? "The simulator publishes its battery. What you publish here takes its place, until you stop."
          : someoneElse
            ? "Someone else publishes battery states: a robot, or ros2 topic pub. What you publish here mixes with theirs."
            : "This gateway publishes nothing by itself now."}
      </Text>
    </Group>
  );
}
