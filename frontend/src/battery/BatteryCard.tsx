import { Badge, Code, Group, RingProgress, Stack, Text, VisuallyHidden } from "@mantine/core";
import type { BatteryState } from "../api/types";
import { useGatewayNow } from "../store/clock";
import { useLive, useServices, useTopic } from "../store/context";
import { Fact, FactList } from "../ui/Fact";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { formatDuration } from "../ui/time";
import {
  CHARGING,
  FULL,
  formatCells,
  formatPercentage,
  formatQuantity,
  HEALTH_WORDS,
  statusWords,
  TECHNOLOGY_WORDS,
} from "./words";

export function BatteryCard() {
  const { state, receivedAt, staleAfterS } = useTopic("battery");
  const live = useLive();
  const now = useGatewayNow(200);
  const age = receivedAt === null ? null : Math.max(0, now - receivedAt);
  const stale = age !== null && age > staleAfterS * 1000;

  return (
    <Section title="Battery" aside={<Freshness live={live} known={state !== null} stale={stale} />}>
      {state === null || receivedAt === null || age === null ? (
        <NoBattery live={live} />
      ) : (
        <Stack gap="md">
          <Group gap="md" align="center">
            <Gauge state={state} faded={stale || !live} />
            <Stack gap={4}>
              <Text fw={700} fz="xl" lh={1.2} data-testid="battery-status">
                {statusWords(state.power_supply_status)}
              </Text>
              <Text className="tabular">{formatQuantity(state.voltage, "V")}</Text>
              <Text size="sm" c="dimmed" className="tabular">
                {age < 1500 ? "just now" : `${formatDuration(age)} ago`}, at <Time value={receivedAt} />
              </Text>
            </Stack>
          </Group>
          {stale && live && (
            <Text size="sm" role="status">
              <strong>Stale:</strong> no battery message for more than {staleAfterS} s. A docking server keeps
              the robot still until one comes.
            </Text>
          )}
          <Measurements state={state} />
        </Stack>
      )}
    </Section>
  );
}

function Freshness({ live, known, stale }: { live: boolean; known: boolean; stale: boolean }) {
  if (!live) return <Badge color="gray.7">Not live</Badge>;
  if (!known) return <Badge color="gray.7">No data</Badge>;
  return stale ? <Badge color="orange">Stale</Badge> : <Badge color="green">Live</Badge>;
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

function Gauge({ state, faded }: { state: BatteryState; faded: boolean }) {
  const measured = state.percentage !== null;
  const value = Math.min(100, Math.max(0, (state.percentage ?? 0) * 100));
  return (
    <div>
      <VisuallyHidden>Percentage</VisuallyHidden>
      <RingProgress
        size={148}
        thickness={13}
        roundCaps
        sections={measured ? [{ value, color: gaugeColor(state, value, faded) }] : []}
        label={
          <Text
            ta="center"
            fw={700}
            fz={measured ? "lg" : "sm"}
            className="tabular"
            style={measured ? { whiteSpace: "nowrap" } : undefined}
          >
            {formatPercentage(state.percentage)}
          </Text>
        }
      />
    </div>
  );
}

function gaugeColor(state: BatteryState, value: number, faded: boolean): string {
  if (faded) return "gray.5";
  if (state.power_supply_status === CHARGING || state.power_supply_status === FULL) return "green";
  return value < 25 ? "orange" : "blue";
}

/** The fields that a battery may leave out, where it does not. */
function Measurements({ state }: { state: BatteryState }) {
  const facts: [string, string][] = [];
  const measure = (name: string, value: number | null, unit: string) => {
    if (value !== null) facts.push([name, formatQuantity(value, unit)]);
  };
  measure("Current", state.current, "A");
  measure("Temperature", state.temperature, "°C");
  measure("Charge", state.charge, "Ah");
  measure("Capacity", state.capacity, "Ah");
  measure("Design capacity", state.design_capacity, "Ah");
  if (state.power_supply_health > 0) {
    facts.push(["Health", HEALTH_WORDS[state.power_supply_health] ?? String(state.power_supply_health)]);
  }
  if (state.power_supply_technology > 0) {
    const technology = state.power_supply_technology;
    facts.push(["Technology", TECHNOLOGY_WORDS[technology] ?? String(technology)]);
  }
  if (state.cell_voltage.length > 0) facts.push(["Cells", formatCells(state.cell_voltage, "V")]);
  if (state.cell_temperature.length > 0)
    facts.push(["Cell temperatures", formatCells(state.cell_temperature, "°C")]);
  if (state.location !== "") facts.push(["Location", state.location]);
  if (state.serial_number !== "") facts.push(["Serial number", state.serial_number]);
  if (facts.length === 0) return null;
  return (
    <FactList>
      {facts.map(([name, value]) => (
        <Fact key={name} name={name}>
          {value}
        </Fact>
      ))}
    </FactList>
  );
}
