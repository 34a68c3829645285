import { Code, Group, Stack, Text, VisuallyHidden } from "@mantine/core";
import { useState } from "react";
import type { BatteryState } from "../api/types";
import { useAtTime } from "../store/clock";
import { useServices, useTopicPart } from "../store/context";
import { useFreshness } from "../store/freshness";
import { RENDER_INTERVAL_MS } from "../store/shown";
import { Fact, FactList } from "../ui/Fact";
import { FreshnessBadge } from "../ui/FreshnessBadge";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { formatDuration } from "../ui/time";
import { Ring } from "./Ring";
import {
  CHARGING,
  FULL,
  formatCells,
  formatPercentage,
  formatQuantity,
  HEALTH_WORDS,
  isLow,
  statusWords,
  TECHNOLOGY_WORDS,
} from "./words";

/** A message is as good as now for this long (ms). */
const JUST_NOW_MS = 1500;
/** The ring follows in steps of so much (percent), which are a pixel of it. */
const RING_STEP = 0.25;

/** The battery as it is now. Messages come often: each text reads for itself what it says. */
export function BatteryCard() {
  const freshness = useFreshness("battery");
  const known = useTopicPart("battery", ({ state }) => state !== null);

  return (
    <Section title="Battery" aside={<FreshnessBadge freshness={freshness} />}>
      {known ? (
        <Stack gap="md">
          <Group gap="md" align="center">
            <Gauge faded={freshness !== "live"} />
            <Stack gap={4}>
              <Text fw={700} fz="xl" lh={1.2} data-testid="battery-status">
                <Said read={(state) => statusWords(state.power_supply_status)} />
              </Text>
              <Text className="tabular">
                <Said read={(state) => formatQuantity(state.voltage, "V")} />
              </Text>
              <Text size="sm" c="dimmed" className="tabular">
                <Age />
              </Text>
            </Stack>
          </Group>
          {freshness === "stale" && <StaleWarning />}
          <Measurements />
        </Stack>
      ) : (
        <NoBattery live={freshness !== "offline"} />
      )}
    </Section>
  );
}

/** A text about the battery, rendered anew where it is another. */
function Said({ read }: { read: (state: BatteryState) => string }) {
  return useTopicPart("battery", ({ state }) => (state === null ? "" : read(state)));
}

function Age() {
  const { store } = useServices();
  const words = useAtTime((now) => {
    const age = now - (store.get("battery").receivedAt ?? now);
    return age < JUST_NOW_MS ? "just now" : `${formatDuration(age)} ago`;
  }, RENDER_INTERVAL_MS);
  const at = useAtTime((now) => {
    const receivedAt = store.get("battery").receivedAt ?? now;
    // To the second while messages come: nobody could read more.
    return now - receivedAt < JUST_NOW_MS ? Math.floor(receivedAt / 1000) * 1000 : receivedAt;
  }, RENDER_INTERVAL_MS);
  return (
    <>
      {words}, at <Time value={at} />
    </>
  );
}

function StaleWarning() {
  const staleAfterS = useTopicPart("battery", (battery) => battery.staleAfterS);
  return (
    <Text size="sm" role="status">
      <strong>Stale:</strong> no battery message for more than {staleAfterS} s. A docking server keeps the
      robot still until one comes.
    </Text>
  );
}

function NoBattery({ live }: { live: boolean }) {
  const { robot } = useServices();
  const topic = `${robot === null || robot === "/" ? "" : robot}/battery_status`;
  return (
    <Stack gap={4} data-testid="battery-status">
      <Text fw={600}>No battery state yet</Text>
      <Text size="sm" c="dimmed">
        {live
          ? "Nothing has been published on the battery topic. Start the robot's battery driver, or let this gateway publish: "
          : "Nothing is known before the gateway is connected."}
        {live && (
          <>
            choose a preset under <em>Publish a battery state</em> and press <em>Publish repeatedly</em>. In a
            terminal: <Code>ros2 topic pub {topic} sensor_msgs/BatteryState …</Code>
          </>
        )}
      </Text>
    </Stack>
  );
}

function Gauge({ faded }: { faded: boolean }) {
  const value = useTopicPart("battery", ({ state }) => filled(state?.percentage ?? null));
  const color = useTopicPart("battery", ({ state, lowBelow }) => gaugeColor(state, lowBelow, faded));
  const measured = value !== null;
  return (
    <div>
      <VisuallyHidden>Percentage</VisuallyHidden>
      <Ring value={value} color={`var(--mantine-color-${color})`}>
        <Text
          ta="center"
          fw={700}
          fz={measured ? "lg" : "sm"}
          className="tabular"
          style={measured ? { whiteSpace: "nowrap" } : undefined}
        >
          <Said read={({ percentage }) => formatPercentage(percentage)} />
        </Text>
      </Ring>
    </div>
  );
}

/** So much of the ring, in percent. */
function filled(percentage: number | null): number | null {
  if (percentage === null) return null;
  const value = Math.min(100, Math.max(0, percentage * 100));
  return Math.round(value / RING_STEP) * RING_STEP;
}

function gaugeColor(state: BatteryState | null, lowBelow: number, faded: boolean): string {
  if (faded) return "gray-5";
  const status = state?.power_supply_status;
  if (status === CHARGING || status === FULL) return "green-filled";
  return state !== null && isLow(state, lowBelow) ? "orange-filled" : "blue-filled";
}

/** The fields that a battery may leave out, and what they say where it does not. */
const MEASUREMENTS: Record<string, (state: BatteryState) => string | null> = {
  Current: ({ current }) => measured(current, "A"),
  Temperature: ({ temperature }) => measured(temperature, "°C"),
  Charge: ({ charge }) => measured(charge, "Ah"),
  Capacity: ({ capacity }) => measured(capacity, "Ah"),
  "Design capacity": ({ design_capacity }) => measured(design_capacity, "Ah"),
  Health: ({ power_supply_health: health }) => (health > 0 ? (HEALTH_WORDS[health] ?? String(health)) : null),
  Technology: ({ power_supply_technology: technology }) =>
    technology > 0 ? (TECHNOLOGY_WORDS[technology] ?? String(technology)) : null,
  Cells: ({ cell_voltage: cells }) => (cells.length > 0 ? formatCells(cells, "V") : null),
  "Cell temperatures": ({ cell_temperature: cells }) => (cells.length > 0 ? formatCells(cells, "°C") : null),
  Location: ({ location }) => location || null,
  "Serial number": ({ serial_number }) => serial_number || null,
};

function measured(value: number | null, unit: string): string | null {
  return value === null ? null : formatQuantity(value, unit);
}

/** What is measured, and what was measured since this was opened and is no more. */
function Measurements() {
  const names = useTopicPart("battery", ({ state }) =>
    Object.entries(MEASUREMENTS)
      .flatMap(([name, words]) => (state !== null && words(state) !== null ? [name] : []))
      .join(","),
  );
  const [everMeasured, setEverMeasured] = useState<readonly string[]>([]);
  const added = names.split(",").filter((name) => name !== "" && !everMeasured.includes(name));
  if (added.length > 0) setEverMeasured([...everMeasured, ...added]);
  if (everMeasured.length === 0) return null;
  return (
    <FactList>
      {Object.entries(MEASUREMENTS).map(
        ([name, words]) =>
          everMeasured.includes(name) && (
            <Fact key={name} name={name}>
              <Said read={(state) => words(state) ?? "no longer measured"} />
            </Fact>
          ),
      )}
    </FactList>
  );
}
