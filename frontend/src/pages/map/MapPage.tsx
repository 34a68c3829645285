import { Skeleton, Stack, Text } from "@mantine/core";
import { useEffect, useMemo, useState, useSyncExternalStore } from "react";
import { Link } from "react-router";
import { useAtTime } from "../../clock/clock";
import { FreshnessBadge } from "../../fleet/badges";
import { useFleetLive, useFleetTopic, useNaming } from "../../fleet/context";
import { robotPath } from "../../fleet/path";
import { freshnessOf, SCENE_STALE_MS } from "../../store/freshness";
import { openStream, streamUrl } from "../../stream/stream";
import { PageTitle } from "../../ui/PageTitle";
import { Section } from "../../ui/Section";
import { FleetMap } from "./FleetMap";
import { FleetScenes } from "./fleetScenes";
import classes from "./map.module.css";
import { type Missing, placement } from "./placement";

const FRESHNESS_MS = 400;

/** All robots whose poses share a frame on one map, and the others beside it. */
export default function MapPage() {
  const scenes = useFleetScenes();
  const frames = useSyncExternalStore(scenes.subscribe, () => scenes.frames);
  const robots = useFleetTopic("robots");
  const alerts = useFleetTopic("alerts");
  const { placed, missing } = useMemo(
    () => placement(robots.values(), frames ?? new Map(), alerts),
    [robots, frames, alerts],
  );
  return (
    <Stack gap="md">
      <PageTitle title="Map" />
      <div className={classes.page}>
        <Section title="Robots" aside={<Fresh scenes={scenes} />}>
          {frames === null ? (
            <Skeleton className={classes.frame ?? ""} />
          ) : placed.length > 0 ? (
            <FleetMap scenes={scenes} placed={placed} />
          ) : (
            <Nobody />
          )}
        </Section>
        {frames !== null && missing.length > 0 && <NotShown missing={missing} />}
      </div>
    </Stack>
  );
}

/** The scenes of all robots, for as long as the page is shown. */
function useFleetScenes(): FleetScenes {
  const [scenes] = useState(() => new FleetScenes());
  useEffect(
    () => openStream(streamUrl(window.location, { include: "scenes", feedback: "false" }), scenes),
    [scenes],
  );
  return scenes;
}

function Fresh({ scenes }: { scenes: FleetScenes }) {
  const live = useFleetLive();
  const freshness = useAtTime(() => {
    const age = scenes.frames === null ? null : performance.now() - scenes.arrivedAt;
    return freshnessOf(live, age, SCENE_STALE_MS);
  }, FRESHNESS_MS);
  return <FreshnessBadge freshness={freshness} />;
}

function Nobody() {
  return (
    <Stack gap={4} className={classes.empty}>
      <Text fw={600}>No robot on this map</Text>
      <Text size="sm" c="dimmed">
        Robots share a map if their poses are in one frame, as those of simulated robots are. Odometry alone
        has a frame for each robot: it is on the robot's own page.
      </Text>
    </Stack>
  );
}

function NotShown({ missing }: { missing: readonly Missing[] }) {
  const naming = useNaming();
  return (
    <Section title="Not on the map">
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
