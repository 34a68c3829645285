import type { BatteryState } from "@dock-gateway/client";
import { Box, Button, Code, Paper, Skeleton, Text, Title } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Suspense, useId, useState } from "react";
import { useAtTime } from "../clock/clock";
import { FreshnessBadge } from "../fleet/badges";
import { useRobotPart } from "../fleet/robot";
import { useFreshness, useServices, useTopicPart } from "../store/context";
import { RENDER_INTERVAL_MS } from "../store/streamStore";
import { Fact, FactList } from "../ui/Fact";
import { HelpLink } from "../ui/HelpLink";
import { lazyPart } from "../ui/lazyPart";
import { Section } from "../ui/Section";
import { formatDuration } from "../ui/time";
import plotClasses from "./BatteryPlots.module.css";
import classes from "./battery.module.css";
import {
  CHARGING,
  FULL,
  formatCells,
  formatPercentage,
  formatQuantity,
  HEALTH_WORDS,
  implausibleWords,
  isLow,
  statusOf,
  statusWords,
  TECHNOLOGY_WORDS,
} from "./words";

/** A message is as good as now for this long (ms). */
const JUST_NOW_MS = 1500;
/** The bar follows in steps of this many percent, which are a pixel of it. */
const BAR_STEP = 2;

/** The battery as it is now, in a row. Messages come often: each text reads for itself what it says. */
export function BatteryCard() {
  const freshness = useFreshness("battery");
  const known = useTopicPart("battery", ({ state }) => state !== null);
  const [moreOpen, more] = useDisclosure(false);
  const moreNames = useMeasured(MORE);
  const id = useId();
  const moreId = useId();

  return (
    <Paper
      component="section"
      withBorder
      radius="md"
      px={{ base: "md", sm: "lg" }}
      py="sm"
      aria-labelledby={id}
    >
      <div className={classes.strip}>
        <div className={classes.title}>
          <Title order={2} size="h4" id={id}>
            Battery
          </Title>
          <HelpLink to="robots#battery" about="Battery" />
          <FreshnessBadge freshness={freshness} />
        </div>
        {known ? <Values old={freshness !== "live"} /> : <NoBattery live={freshness !== "offline"} />}
        {moreNames.length > 0 && (
          <Button
            variant="default"
            size="compact-md"
            aria-expanded={moreOpen}
            aria-controls={moreId}
            onClick={more.toggle}
          >
            {moreOpen ? "Fewer values" : "More values"}
          </Button>
        )}
      </div>
      {freshness === "stale" && <StaleWarning />}
      <ImplausibleWarning />
      <div id={moreId} hidden={!moreOpen}>
        {moreOpen && (
          <Box mt="sm">
            <FactList>
              <Measurements names={moreNames} />
            </FactList>
          </Box>
        )}
      </div>
    </Paper>
  );
}

/** What is looked at every day. */
function Values({ old }: { old: boolean }) {
  const charging = useRobotPart((robot) => robot?.charging ?? null);
  return (
    <dl className={classes.values}>
      <Fact name="Percentage">
        <span className={classes.level}>
          <Gauge old={old} charging={charging} />
          <Said read={({ percentage }) => formatPercentage(percentage)} />
        </span>
      </Fact>
      <Fact name="Status">
        <span data-testid="battery-status">
          <Said read={(state) => statusWords(statusOf(state.power_supply_status, charging))} />
        </span>
      </Fact>
      <Fact name="Voltage">
        <Said read={(state) => formatQuantity(state.voltage, "V")} />
      </Fact>
      <Measurements names={useMeasured(MAIN)} />
      <Fact name="Last message">
        <Age />
      </Fact>
    </dl>
  );
}

/** A text about the battery, re-rendered where it is another. */
function Said({ read }: { read: (state: BatteryState) => string }) {
  return useTopicPart("battery", ({ state }) => (state === null ? "" : read(state)));
}

function Age() {
  const { store } = useServices();
  return useAtTime((now) => {
    const age = now - (store.get("battery").receivedAt ?? now);
    return age < JUST_NOW_MS ? "just now" : `${formatDuration(age)} ago`;
  }, RENDER_INTERVAL_MS);
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

function ImplausibleWarning() {
  const words = useTopicPart("battery", ({ implausible }) => implausible.map(implausibleWords).join("; "));
  if (words === "") return null;
  return (
    <Text size="sm" role="status">
      <strong>Implausible, not used:</strong> {words}.
    </Text>
  );
}

function NoBattery({ live }: { live: boolean }) {
  const { robot } = useServices();
  const topic = `${robot === null || robot === "/" ? "" : robot}/battery_status`;
  return (
    <Text size="sm" data-testid="battery-status" className={classes.none}>
      <strong>No battery state yet.</strong>{" "}
      {live ? (
        <>
          Nothing has been published on <Code>{topic}</Code>. Start the robot's battery driver, or publish a
          battery state in the Developer tab.
        </>
      ) : (
        "Nothing is known before the gateway is connected."
      )}
    </Text>
  );
}

function Gauge({ old, charging }: { old: boolean; charging: boolean | null }) {
  const filled = useTopicPart("battery", ({ state }) => inSteps(state?.percentage ?? null));
  const charge = useTopicPart("battery", ({ state, lowBelow }) =>
    state === null ? "ok" : chargeOf(state, lowBelow, charging),
  );
  return <ChargeBar filled={filled} charge={charge} old={old} />;
}

/** In percent, in steps. */
function inSteps(percentage: number | null): number | null {
  if (percentage === null) return null;
  const value = Math.min(100, Math.max(0, percentage * 100));
  return Math.round(value / BAR_STEP) * BAR_STEP;
}

type Words = (state: BatteryState) => string | null;

/** The fields that a battery may leave out, and what they say where it does not: those that are always in sight. */
const MAIN: Record<string, Words> = {
  Current: ({ current }) => measured(current, "A"),
  Temperature: ({ temperature }) => measured(temperature, "°C"),
};

const MORE: Record<string, Words> = {
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

/** Which of the fields are measured, or were since this was opened. */
function useMeasured(fields: Record<string, Words>): readonly string[] {
  const names = useTopicPart("battery", ({ state }) =>
    Object.entries(fields)
      .flatMap(([name, words]) => (state !== null && words(state) !== null ? [name] : []))
      .join(","),
  );
  const [everMeasured, setEverMeasured] = useState<readonly string[]>([]);
  const added = names.split(",").filter((name) => name !== "" && !everMeasured.includes(name));
  if (added.length > 0) setEverMeasured([...everMeasured, ...added]);
  return everMeasured;
}

/** Fields of a battery, each with its value or that there is none any more. */
function Measurements({ names }: { names: readonly string[] }) {
  return Object.entries({ ...MAIN, ...MORE }).map(
    ([name, words]) =>
      names.includes(name) && (
        <Fact key={name} name={name}>
          <Said read={(state) => words(state) ?? "no longer measured"} />
        </Fact>
      ),
  );
}

/** What draws them comes after the page, which is of use without. */
const BatteryPlots = lazyPart(() => import("./BatteryPlots"));

export function BatteryPlotsCard() {
  return (
    <Section title="Battery over time" help="dashboard#the-battery-over-days">
      <Suspense fallback={<Skeleton className={plotClasses.waiting} />}>
        <BatteryPlots />
      </Suspense>
    </Section>
  );
}

export type Charge = "charging" | "low" | "ok";

/**
 * What the colour of a battery's bar says.
 *
 * @param charging What the gateway knows beyond the status; null where that is nothing.
 */
export function chargeOf(
  state: { percentage: number | null; power_supply_status: number },
  lowBelow: number,
  charging: boolean | null,
): Charge {
  const status = state.power_supply_status;
  if (charging || status === CHARGING || status === FULL) return "charging";
  return isLow(state, lowBelow) ? "low" : "ok";
}

interface ChargeBarProps {
  /** In percent; null where it is not measured. */
  filled: number | null;
  charge: Charge;
  /** Whether the value is not current. */
  old?: boolean;
}

/** A picture of how full a battery is; the text next to it says the same. */
export function ChargeBar({ filled, charge, old = false }: ChargeBarProps) {
  return (
    <span className={classes.bar} data-charge={charge} data-old={old || undefined} aria-hidden="true">
      {filled !== null && <span style={{ inlineSize: `${filled}%` }} />}
    </span>
  );
}
