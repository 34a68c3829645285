import { Button, Group, NumberInput, SimpleGrid, Skeleton, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Suspense, useId, useState } from "react";
import { useForbidden } from "../api/permissions";
import { useLive, useServices, useTopicPart } from "../store/context";
import { CommandErrorAlert } from "../ui/errors";
import { lazyPart } from "../ui/lazyPart";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { MainFields } from "./BatteryFields";
import { type BatteryForm, type NumberInputValue, PRESETS, sameForm, toMessage, toNumber } from "./form";
import { PublisherStatus } from "./PublisherStatus";
import { summarize } from "./words";

/** Comes when it is asked for. */
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
    <Section title="Publish a battery state">
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
