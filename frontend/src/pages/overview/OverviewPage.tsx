import type { Robot } from "@dock-gateway/client";
import { Anchor, Button, Group, Paper, Skeleton, Stack, Text, VisuallyHidden } from "@mantine/core";
import { type ComponentType, Suspense, useMemo, useState } from "react";
import { Link } from "react-router";
import { AlertList } from "../../alerts/AlertList";
import { apiAddress } from "../../api/site";
import { useFleetLive, useFleetTopic } from "../../fleet/context";
import { isThere } from "../../fleet/words";
import { useAddress } from "../../ui/address";
import { Command } from "../../ui/CopyButton";
import { lazyPart } from "../../ui/lazyPart";
import { Section, usePageTitle } from "../../ui/Section";
import { RobotView } from "../robot/RobotPage";
import { overviewView } from "./list";
import classes from "./overview.module.css";
import { Shares } from "./Shares";

const RobotTable = lazyPart(() => import("./RobotTable"));

/** All robots; where there is a single one, the page of that. */
export default function OverviewPage() {
  return <WhenKnown of={Known} />;
}

interface OfRobots {
  robots: ReadonlyMap<string, Robot>;
}

/** An overview, once it is known which robots there are. */
export function WhenKnown({ of: Overview }: { of: ComponentType<OfRobots> }) {
  usePageTitle("Overview");
  const robots = useFleetTopic("robots");
  const live = useFleetLive();
  const [told, setTold] = useState(false);
  if (!told && (live || robots.size > 0)) setTold(true);
  return told ? <Overview robots={robots} /> : <OverviewSkeleton />;
}

function Known({ robots }: OfRobots) {
  const there = useMemo(() => [...robots.values()].filter(isThere), [robots]);
  const [{ group }] = useAddress(overviewView);
  const [view, setView] = useState<"one" | "all">(there.length > 1 ? "all" : "one");
  const [one, setOne] = useState<string | null>(null);
  const [touched, setTouched] = useState(false);
  // With the first few a page may begin with one robot, and become that of all. It is not taken from under somebody's
  // hands, and it does not go back: after a restart the gateway finds robots one by one.
  if (view === "one" && there.length > 1 && !touched) setView("all");
  const only = there.length > 1 ? one : (there[0]?.name ?? null);
  if (only !== one) setOne(only);

  if (view === "all") {
    return (
      <>
        <Heading />
        <AlertList group={group} />
        <Shares />
        <Suspense fallback={<Skeleton height={360} />}>
          <RobotTable robots={there} />
        </Suspense>
      </>
    );
  }
  const robot = only === null ? undefined : robots.get(only);
  return (
    <Stack gap="md" onPointerDownCapture={() => setTouched(true)} onKeyDownCapture={() => setTouched(true)}>
      {there.length > 1 && <MoreRobots count={there.length} onShow={() => setView("all")} />}
      <AlertList quiet />
      <Shares />
      {robot === undefined && <NoRobot />}
      <RobotView robot={scopeOf(robot)} />
    </Stack>
  );
}

/** The configured robot is asked for without a name. */
function scopeOf(robot: Robot | undefined): string | null {
  return robot === undefined || robot.default ? null : robot.name;
}

function MoreRobots({ count, onShow }: { count: number; onShow: () => void }) {
  return (
    <Paper withBorder radius="md" p="sm" role="status">
      <Group justify="space-between" gap="sm">
        <Text>There are {count} robots now.</Text>
        <Button variant="default" size="compact-md" onClick={onShow}>
          Show all
        </Button>
      </Group>
    </Paper>
  );
}

export function Heading() {
  return (
    <VisuallyHidden>
      <h1>Overview</h1>
    </VisuallyHidden>
  );
}

function OverviewSkeleton() {
  return (
    <Stack gap="md" role="group" aria-busy="true" aria-label="The robots are not known yet">
      <Heading />
      <Skeleton height={140} />
      <Skeleton height={360} />
    </Stack>
  );
}

/** What to do where no robot is on the graph. */
function NoRobot() {
  const battery = `curl -sX PUT ${apiAddress()}/battery/publisher -d '{"state": {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3}, "rate_hz": 1}' -H 'Content-Type: application/json'`;
  return (
    <Section title="No robot yet" help="troubleshooting">
      <Text size="sm">
        A robot appears here by itself, as soon as its docking action or its battery topic is on the ROS
        graph. The{" "}
        <Anchor component={Link} to="/ui/graph" inherit underline="always">
          graph
        </Anchor>{" "}
        shows what this gateway sees; where that is nothing, look at ROS_DOMAIN_ID here and there.
      </Text>
      <div className={classes.steps}>
        <Step what="A simulated robot and its docking server">
          <Command line="dock_simulator & docking_server" what="the command that simulates a robot" />
        </Step>
        <Step what="The tutorial's action server">
          <Command line="connect_to_charging_dock_server" what="the command that starts the action server" />
        </Step>
        <Step what="A battery, published by this gateway">
          <Command line={battery} what="the command that publishes a battery" />
        </Step>
      </div>
    </Section>
  );
}

function Step({ what, children }: { what: string; children: React.ReactNode }) {
  return (
    <div>
      <Text size="sm" mb={2}>
        {what}
      </Text>
      {children}
    </div>
  );
}
