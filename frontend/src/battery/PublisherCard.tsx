import type { Publisher } from "@dock-gateway/client";
import { Alert, Badge, Button, Group, NumberInput, SimpleGrid, Skeleton, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useQuery } from "@tanstack/react-query";
import { Suspense, useId, useState } from "react";
import { findTopic, type GraphTopic, gatewayNode } from "../api/graph";
import { useForbidden } from "../api/session";
import { useFleet, useFleetPart } from "../fleet/context";
import { useLive, useServices, useTopic, useTopicPart } from "../store/context";
import { CommandErrorAlert } from "../ui/errors";
import { lazyPart } from "../ui/lazyPart";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { MainFields } from "./BatteryFields";
import { type BatteryForm, type NumberInputValue, PRESETS, sameForm, toMessage, toNumber } from "./form";
import { summarize } from "./words";

/** Loaded when more fields are asked for. */
const MoreFields = lazyPart(() => import("./MoreFields"));

const MIN_RATE_HZ = 0.1;
const MAX_RATE_HZ = 100;

/** Publishes battery states, as `ros2 topic pub` does: once, or again and again. */
export function PublisherCard() {
  const { gateway, store } = useServices();
  const live = useLive();
  const forbidden = useForbidden("POST /battery");
  const active = useTopicPart("publisher", (publisher) => publisher?.active === true);
  const [form, setForm] = useState<BatteryForm>(PRESETS[0].form);
  const [rateInput, setRateInput] = useState<NumberInputValue>(1);
  const [done, setDone] = useState<{ at: number; text: string } | null>(null);
  const [moreOpen, more] = useDisclosure(false);
  const moreId = useId();

  const change = (part: Partial<BatteryForm>) => setForm((before) => ({ ...before, ...part }));
  const message = toMessage(form);
  const rate = toNumber(rateInput);
  const finish = (text: string) => setDone({ at: store.gatewayNow(), text });
  const once = useCommand(async (state: NonNullable<typeof message>) => {
    await gateway.publishOnce(state);
    finish(`Published once: ${summarize(state)}.`);
  });
  const repeatedly = useCommand(async (input: { state: NonNullable<typeof message>; rate: number }) => {
    await gateway.publishRepeatedly(input.state, input.rate);
    finish(`Publishing ${summarize(input.state)} at ${input.rate} Hz.`);
  });
  const stop = useCommand(async () => {
    await gateway.stopPublishing();
    finish("Stopped publishing.");
  });
  const commands = [once, repeatedly, stop];
  const begin = () => {
    setDone(null);
    for (const command of commands) command.reset();
  };

  const busy = commands.some((command) => command.isPending);
  const rateWrong = rate === null || rate < MIN_RATE_HZ || rate > MAX_RATE_HZ;
  const why =
    forbidden ??
    (!live
      ? "Publishing needs the gateway, which is not connected."
      : busy
        ? "The gateway has not answered yet."
        : null);
  const whyNotOnce = why ?? (message === null ? "A field is not valid." : null);
  const whyNotRepeatedly =
    whyNotOnce ?? (rateWrong ? `The rate has to be ${MIN_RATE_HZ} to ${MAX_RATE_HZ} Hz.` : null);
  const whyNotStop = why ?? (active ? null : "Nothing is being published.");

  return (
    <Section title="Publish a battery state" help="robots#battery">
      <PublisherStatus />
      <Group gap="xs" role="group" aria-label="Presets">
        {PRESETS.map((preset) => {
          const chosen = sameForm(form, preset.form);
          return (
            <Button
              key={preset.name}
              variant={chosen ? "filled" : "default"}
              aria-pressed={chosen}
              onClick={() => setForm(preset.form)}
            >
              {preset.name}
            </Button>
          );
        })}
      </Group>
      <SimpleGrid cols={{ base: 2, xs: 4 }} spacing="sm">
        <MainFields form={form} onChange={change} />
        <NumberInput
          label="Rate (Hz)"
          min={MIN_RATE_HZ}
          max={MAX_RATE_HZ}
          value={rateInput}
          onChange={setRateInput}
        />
      </SimpleGrid>
      <Group gap="sm">
        <Button
          variant="default"
          size="compact-md"
          aria-expanded={moreOpen}
          aria-controls={moreId}
          onClick={more.toggle}
        >
          {moreOpen ? "Fewer fields" : "More fields"}
        </Button>
        <Text size="sm" c="dimmed">
          Leave a number empty to send NaN.
        </Text>
      </Group>
      <div id={moreId} hidden={!moreOpen}>
        {moreOpen && (
          <Suspense fallback={<Skeleton height={340} />}>
            <MoreFields form={form} onChange={change} />
          </Suspense>
        )}
      </div>
      <Stack gap="xs">
        <Group gap="sm">
          <ReasonButton
            reason={whyNotRepeatedly}
            onClick={() => {
              begin();
              if (message !== null && rate !== null) repeatedly.mutate({ state: message, rate });
            }}
          >
            Publish repeatedly
          </ReasonButton>
          <ReasonButton
            variant="default"
            reason={whyNotOnce}
            onClick={() => {
              begin();
              if (message !== null) once.mutate(message);
            }}
          >
            Publish once
          </ReasonButton>
          <ReasonButton
            variant="default"
            reason={whyNotStop}
            onClick={() => {
              begin();
              stop.mutate();
            }}
          >
            Stop publishing
          </ReasonButton>
        </Group>
        <Text size="sm" role="status">
          {done !== null && (
            <>
              {done.text} <Time value={done.at} />
            </>
          )}
        </Text>
      </Stack>
      <CommandErrorAlert command="Publish once" error={once.error} onClose={once.reset} />
      <CommandErrorAlert command="Publish repeatedly" error={repeatedly.error} onClose={repeatedly.reset} />
      <CommandErrorAlert command="Stop publishing" error={stop.error} onClose={stop.reset} />
    </Section>
  );
}

/** What the gateway publishes now, and who else does. */
function PublisherStatus() {
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

/** Between two requests for the graph. */
const RENEW_MS = 5000;

interface Publishers {
  topic: string;
  /** Neither this gateway nor a simulator: battery drivers, and `ros2 topic pub`. */
  others: string[];
  /** The simulator's, where it is one. */
  simulators: string[];
}

/** Who can publish on the battery's topic, by the names of their nodes. */
export function whoPublishes(topic: GraphTopic, gateway: string | null, simulated: boolean): Publishers {
  const names = topic.publishers.map(({ node }) => node).filter((node) => node !== gateway || node === null);
  const isSimulator = (node: string | null) => simulated && node?.endsWith("/dock_simulator") === true;
  return {
    topic: topic.name,
    others: distinct(names.filter((node) => !isSimulator(node)).map(describeNode)),
    simulators: distinct(names.filter(isSimulator).map(describeNode)),
  };
}

function describeNode(node: string | null): string {
  if (node === null) return "a DDS program that is no ROS node";
  return /\/_ros2cli_\d+$/.test(node) ? "ros2 topic pub" : node;
}

function distinct(names: readonly string[]): string[] {
  return [...new Set(names)].sort();
}

/** Who can publish this robot's battery now; null while that is unknown. */
function usePublishers(): Publishers | null {
  const { http } = useFleet();
  const { robot } = useServices();
  const live = useLive();
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const name = useFleetPart(
    "robots",
    (robots) =>
      [...robots.values()].find((each) => (robot === null ? each.default : each.name === robot))
        ?.battery_topic,
  );
  const own = useQuery({
    queryKey: ["gateway-node"],
    queryFn: () => gatewayNode(http),
    enabled: live,
    staleTime: Number.POSITIVE_INFINITY,
  });
  const topic = useQuery({
    queryKey: ["topic", name],
    queryFn: () => findTopic(http, name ?? ""),
    enabled: live && name !== undefined,
    refetchInterval: RENEW_MS,
  });
  if (!live || topic.data === undefined || own.data === undefined) return null;
  return whoPublishes(topic.data, own.data, simulated);
}
