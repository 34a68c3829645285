import type { Alert, Robot } from "@dock-gateway/client";
import { Skeleton, Stack, Text } from "@mantine/core";
import { useEffect, useMemo, useSyncExternalStore } from "react";
import { Link } from "react-router";
import { openAlerts, urgentFirst } from "../../alerts/order";
import { useAtTime } from "../../clock/clock";
import { FreshnessBadge } from "../../fleet/badges";
import { useFleetLive, useFleetTopic, useNaming } from "../../fleet/context";
import { inOrder, robotPath } from "../../fleet/names";
import { isThere, isUnreachable, LINK_WORDS, linkOf } from "../../fleet/words";
import { freshnessOf, SCENE_STALE_MS } from "../../store/context";
import { openStream, streamUrl } from "../../stream/stream";
import { PageTitle, Section } from "../../ui/Section";
import { FleetMap } from "./FleetMap";
import classes from "./map.module.css";
import { type FleetScenes, type Frames, useFleetScenes } from "./scenes";

const FRESHNESS_MS = 400;

/** All robots whose poses share a frame on one map, and the others beside it. */
export default function MapPage() {
  const scenes = useFleetScenes();
  useEffect(() => openStream(streamUrl(window.location, scenes.query), scenes), [scenes]);
  const known = useFleetTopic("robots");
  const robots = useMemo(() => [...known.values()], [known]);
  return (
    <Stack gap="md">
      <PageTitle title="Map" help="dashboard#maps" />
      <RobotsMap title="Robots" scenes={scenes} robots={robots} />
    </Stack>
  );
}

interface RobotsMapProps {
  title: string;
  /** Whether it takes no room where no robot is on it. */
  compact?: boolean;
  scenes: FleetScenes;
  robots: readonly Robot[];
}

/** The map of robots, with those that are not on it. */
export function RobotsMap({ title, compact = false, scenes, robots }: RobotsMapProps) {
  const frames = useSyncExternalStore(scenes.subscribe, () => scenes.frames);
  const alerts = useFleetTopic("alerts");
  const { placed, missing } = useMemo(
    () => placement(robots, frames ?? new Map(), alerts),
    [robots, frames, alerts],
  );
  return (
    <div className={classes.page}>
      <Section title={title} aside={<Fresh scenes={scenes} />}>
        {frames === null ? (
          <Skeleton className={classes.frame ?? ""} />
        ) : placed.length > 0 ? (
          <FleetMap scenes={scenes} placed={placed} />
        ) : (
          <NoRobots compact={compact} />
        )}
      </Section>
      {frames !== null && missing.length > 0 && (
        <NotShown title={compact ? `Not on the map of ${title}` : "Not on the map"} missing={missing} />
      )}
    </div>
  );
}

function Fresh({ scenes }: { scenes: FleetScenes }) {
  const live = useFleetLive();
  const freshness = useAtTime(() => {
    const age = scenes.frames === null ? null : performance.now() - scenes.arrivedAt;
    return freshnessOf(live, age, SCENE_STALE_MS);
  }, FRESHNESS_MS);
  return <FreshnessBadge freshness={freshness} />;
}

function NoRobots({ compact }: { compact: boolean }) {
  return (
    <Stack gap={4} className={compact ? "" : (classes.empty ?? "")}>
      <Text fw={600}>No robot on this map</Text>
      <Text size="sm" c="dimmed">
        Robots share a map if their poses are in one frame, as those of simulated robots are, or on one map,
        where localization publishes that. Odometry alone has a frame for each robot: it is on the robot's own
        page.
      </Text>
    </Stack>
  );
}

function NotShown({ title, missing }: { title: string; missing: readonly Missing[] }) {
  const naming = useNaming();
  return (
    <Section title={title}>
      <ul className={classes.missing} aria-label="Robots that are not on the map">
        {missing.map(({ robot: { name }, why }) => (
          <li key={name}>
            <Link to={robotPath(name)} className={classes.name ?? ""}>
              {naming.nameOf(name)}
            </Link>
            <Text size="sm" c="dimmed" component="span">
              {why}
            </Text>
          </li>
        ))}
      </ul>
    </Section>
  );
}

/** What sets a robot apart from those that are as they should be. */
export interface Mark {
  level: "critical" | "warning";
  words: string;
}

export interface Placed {
  robot: Robot;
  mark: Mark | null;
}

interface Missing {
  robot: Robot;
  why: string;
}

/** Which robots are on the map, and why the others are not, in the order of every page. Odometry has a frame for each robot alone. */
export function placement(
  robots: Iterable<Robot>,
  frames: Frames,
  alerts: readonly Alert[],
): { placed: Placed[]; missing: Missing[] } {
  const placed: Placed[] = [];
  const missing: Missing[] = [];
  for (const robot of [...robots].sort(inOrder)) {
    const frame = frames.get(robot.name);
    if (frame === "world") placed.push({ robot, mark: markOf(robot, alerts) });
    else if (isThere(robot)) missing.push({ robot, why: reasonOf(robot, frame) });
  }
  return { placed, missing };
}

function reasonOf(robot: Robot, frame: "odom" | undefined): string {
  if (frame === "odom") return "Only odometry, in a frame of its own";
  if (isUnreachable(robot)) return LINK_WORDS[linkOf(robot)];
  return robot.simulated ? "No pose from its simulator" : "No simulator, no odometry yet";
}

function markOf(robot: Robot, alerts: readonly Alert[]): Mark | null {
  if (robot.stop.latched) return { level: "critical", words: "Stopped" };
  const [alert] = urgentFirst(openAlerts(alerts.filter((each) => each.robot === robot.name)));
  if (alert !== undefined) return { level: alert.severity, words: alert.title };
  return isUnreachable(robot) ? { level: "warning", words: LINK_WORDS[linkOf(robot)] } : null;
}
