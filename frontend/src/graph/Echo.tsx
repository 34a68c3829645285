import { Button, Group, Skeleton, Stack, Switch, Text, Title } from "@mantine/core";
import { useEffect, useReducer } from "react";
import { steadyNow } from "../clock/beat";
import { useFleetLive } from "../fleet/context";
import { openStream, streamUrl } from "../stream/stream";
import { CopyButton } from "../ui/CopyButton";
import { Fact, FactList } from "../ui/Fact";
import { MessageTree } from "../ui/MessageTree";
import { Time } from "../ui/Time";
import {
  describeCuts,
  type EchoEvent,
  type EchoInput,
  type EchoState,
  formatBytes,
  formatRate,
  initialEcho,
  reduceEcho,
} from "./echo";
import classes from "./graph.module.css";

interface EchoProps {
  topic: string;
  on: boolean;
  onSwitch: (on: boolean) => void;
}

/** A topic's messages as they come, once somebody asks for them: cameras and lidars load the robot's network. */
export function Echo({ topic, on, onSwitch }: EchoProps) {
  return (
    <Stack gap="xs" component="section" aria-label="Live messages">
      <Group justify="space-between">
        <Title order={3} size="h5">
          Messages
        </Title>
        <Switch
          label="Live"
          labelPosition="left"
          checked={on}
          onChange={(event) => onSwitch(event.currentTarget.checked)}
        />
      </Group>
      {on ? (
        <LiveEcho topic={topic} />
      ) : (
        <Text size="sm" c="dimmed">
          Switch it on to read along. The gateway then subscribes to the topic, whose messages go over the
          robot's network.
        </Text>
      )}
    </Stack>
  );
}

function LiveEcho({ topic }: { topic: string }) {
  const [echo, tell] = useEcho(topic);
  const { rate, latest, held } = echo;
  const shown = held ?? latest;
  return (
    <>
      <FactList>
        <Fact name="Rate">{rate === null ? "–" : formatRate(rate.rate_hz)}</Fact>
        <Fact name="Size">{rate === null ? "–" : formatBytes(rate.bytes_per_s)}</Fact>
        <Fact name="Messages">{rate === null ? "–" : rate.messages}</Fact>
        <Fact name={held === null ? "Latest at" : "Paused at"}>
          {shown === null ? "–" : <Time value={shown.time} />}
        </Fact>
      </FactList>
      <EchoStatus echo={echo} />
      {shown !== null && (
        <>
          <Group gap="xs">
            <Button
              variant="default"
              size="compact-sm"
              miw={92}
              aria-pressed={held !== null}
              onClick={() => tell(held === null ? "pause" : "go on")}
            >
              {held === null ? "Pause" : "Go on"}
            </Button>
            <CopyButton value={JSON.stringify(shown.message, null, 2)} what="the message as JSON" />
          </Group>
          <MessageView message={shown.message} />
          {shown.abbreviated && (
            <Text size="sm" c="dimmed">
              Not all of it is shown: {describeCuts(shown)}.
            </Text>
          )}
        </>
      )}
    </>
  );
}

/** Why there is no message, where there is none. */
function EchoStatus({ echo: { connection, hint, latest, rate } }: { echo: EchoState }) {
  const live = useFleetLive();
  if (connection.phase === "gone" && live)
    return (
      <Text size="sm" role="status">
        The gateway does not let this topic be read: it has gone, or too many topics are read already (20 at
        most).
      </Text>
    );
  if (connection.phase !== "live" && latest !== null)
    return (
      <Text size="sm" role="status">
        Not live: the connection is down. It comes back by itself.
      </Text>
    );
  if (hint !== null)
    return (
      <Text size="sm" role="status">
        {hint}
      </Text>
    );
  if (latest !== null) return null;
  if (connection.phase !== "live" || rate === null) return <Skeleton height={120} aria-busy="true" />;
  return (
    <Text size="sm" role="status" c="dimmed">
      Nothing yet. A message shows up as soon as one is published; latched ones come at once.
    </Text>
  );
}

/** A message, to read; it scrolls, so that what is below stays where it is. */
function MessageView({ message }: { message: unknown }) {
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: what scrolls has to be reachable by keyboard
    <section className={classes.message} tabIndex={0} aria-label="The message">
      <MessageTree value={message} label="Fields" open={2} />
    </section>
  );
}

/** Messages a second that are shown; the rate counts all of them. */
const MAX_RATE = "5";

/** The messages of a topic as they come, for as long as this is mounted. */
function useEcho(topic: string): [EchoState, (kind: "pause" | "go on") => void] {
  const [state, dispatch] = useReducer(reduceEcho, null, () => initialEcho(steadyNow()));
  useEffect(() => {
    const tell = (input: EchoInput) => dispatch(input);
    const url = streamUrl(window.location, { topic, max_rate: MAX_RATE }, "/ws/topics");
    return openStream(url, {
      // This path has events of its own.
      onEvent: (event) => tell({ kind: "event", event: event as unknown as EchoEvent, now: steadyNow() }),
      onConnection: (input) => tell({ kind: "connection", input, now: steadyNow() }),
    });
  }, [topic]);
  return [state, (kind) => dispatch({ kind, now: steadyNow() })];
}
