import { Alert, Badge, Group, Text } from "@mantine/core";
import type { Publisher } from "../api/types";
import { useLive, useTopic } from "../store/context";
import { Time } from "../ui/Time";
import { type Publishers, usePublishers } from "./publishers";
import { summarize } from "./words";

/** What the gateway publishes now, and who else does. */
export function PublisherStatus() {
  const publisher = useTopic("publisher");
  const publishers = usePublishers();
  const live = useLive();
  if (!live) return <Text size="sm">What is being published is not known while disconnected.</Text>;
  const active = publisher?.active === true;
  return (
    <>
      <Group gap="xs" data-testid="publisher-status">
        {active && <Badge color="blue">publishing</Badge>}
        <Text size="sm" className="tabular">
          {active ? <Active publisher={publisher} /> : "Not publishing."}{" "}
          {publishers !== null && <Simulated publishers={publishers} active={active} />}
        </Text>
      </Group>
      {publishers !== null && <Others publishers={publishers} active={active} />}
    </>
  );
}

function Active({ publisher }: { publisher: Publisher }) {
  return (
    <>
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
    </>
  );
}

function Simulated({ publishers: { simulators }, active }: { publishers: Publishers; active: boolean }) {
  if (simulators.length === 0) return null;
  const name = simulators.join(", ");
  return active
    ? `The simulator (${name}) keeps silent until you stop.`
    : `The simulator (${name}) publishes its battery. What you publish here takes its place, until you stop.`;
}

/** A warning where what is published here is not all that the robot hears. */
function Others({ publishers: { topic, others }, active }: { publishers: Publishers; active: boolean }) {
  if (others.length === 0) return null;
  const name = others.join(", ");
  return (
    <Alert
      color="orange"
      title={active ? `${name} publishes too` : `${name} publishes this battery`}
      data-testid="other-publishers"
    >
      <Text size="sm">
        On {topic}. {active ? "What you publish mixes" : "What you publish here would mix"} with its messages,
        and whoever listens, as the docking server does, hears both by turns: the robot may move, or stand
        still, on a state that is not its own.
      </Text>
    </Alert>
  );
}
