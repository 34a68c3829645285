import type { AnyGoal, PoseEvent } from "@dock-gateway/client";
import { Text } from "@mantine/core";
import { useEffect, useId, useMemo, useState } from "react";
import type { GoalReplay } from "../api/goals";
import { onBeat } from "../clock/beat";
import { at, RecordedScene, RecordedSurroundings } from "../scene/recorded";
import { SceneCanvas } from "../scene/SceneCanvas";
import { describePose } from "../scene/words";
import { Trouble } from "../ui/errors";
import { useAnswer } from "../ui/requests";
import { Section } from "../ui/Section";
import { useRecording } from "./RecordingButton";
import { useWatched } from "./useGoalWatch";

/** How often the words follow the picture (ms). */
const WORDS_MS = 400;
const LEAVE = async () => {};
const NO_GHOST = () => {};
const NO_MAP = () => Promise.reject(new Error("a recording has no map"));

/** Where the robot was at the moment that is marked, and its way until then. Nothing where no poses are stored. */
export default function ReplayMap({ goal }: { goal: AnyGoal }) {
  const { api } = useWatched();
  const recorded = useReplay(goal);
  const {
    data: poses = [],
    error,
    refetch,
  } = useAnswer({
    queryKey: ["poses", goal.goal_id, goal.finished_at],
    queryFn: () => api.poses(goal.goal_id),
    staleTime: Number.POSITIVE_INFINITY,
  });
  if (error !== null)
    return <Trouble what="The map could not be loaded" error={error} onRetry={() => void refetch()} />;
  if (poses.length === 0) return null;
  return <Drawn poses={poses} began={Date.parse(goal.created_at)} recorded={recorded} />;
}

interface DrawnProps {
  poses: readonly PoseEvent[];
  /** When the goal began (ms). */
  began: number;
  /** What the goal's recording has; null without one. */
  recorded: GoalReplay | null;
}

function Drawn({ poses, began, recorded }: DrawnProps) {
  const { crosshair } = useWatched();
  const wordsId = useId();
  const scene = useMemo(() => new RecordedScene(poses, began), [poses, began]);
  const seen = useMemo(() => (recorded === null ? null : new RecordedSurroundings(recorded)), [recorded]);
  const around = useMemo(
    () => (seen === null ? undefined : { data: seen, loadMap: NO_MAP, docks: [], blocked: false }),
    [seen],
  );
  const [words, setWords] = useState("");
  useEffect(() => {
    const seek = () => {
      seen?.seek(crosshair.moment);
      scene.seek(crosshair.moment);
    };
    const describe = () => {
      const { latest } = scene;
      if (latest === null) return;
      const where = `Robot at ${describePose(latest.robot)}${latest.frame === "odom" ? ", by odometry" : ""}`;
      setWords([where, ...(recorded === null ? [] : readingsAt(recorded, crosshair.moment))].join("; "));
    };
    seek();
    describe();
    const forget = crosshair.subscribe(seek);
    const stop = onBeat(WORDS_MS, describe);
    return () => {
      forget();
      stop();
    };
  }, [scene, seen, recorded, crosshair]);
  return (
    <Section title="Map">
      <SceneCanvas
        key={seen === null ? "poses" : "recording"}
        scene={scene}
        placeable={false}
        describedBy={wordsId}
        around={around}
        onPlace={LEAVE}
        onGhost={NO_GHOST}
      />
      <Text size="sm" id={wordsId} className="tabular" data-testid="replay-map-words">
        {words}
      </Text>
    </Section>
  );
}

/** What the recording of a goal has; null while it is not known, and without a recording. */
function useReplay(goal: AnyGoal): GoalReplay | null {
  const { api } = useWatched();
  const size = useRecording(goal).data?.size ?? null;
  const { data } = useAnswer({
    queryKey: ["replay", goal.goal_id, size],
    queryFn: () => api.replay(goal.goal_id),
    enabled: size !== null,
    staleTime: Number.POSITIVE_INFINITY,
  });
  return data ?? null;
}

/** What the robot was told at a moment, and what its battery said. */
export function readingsAt({ velocity, battery }: GoalReplay, moment: number | null): string[] {
  const told = at(velocity, moment);
  const said = at(battery, moment);
  const readings = [];
  if (told !== null && told.linear !== null && told.angular !== null)
    readings.push(`commanded ${told.linear.toFixed(2)} m/s, ${told.angular.toFixed(2)} rad/s`);
  if (said !== null && said.voltage !== null) readings.push(`battery ${said.voltage.toFixed(2)} V`);
  return readings.map((reading) => reading.replaceAll("-", "−"));
}
