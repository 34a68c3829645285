import type { AnyGoal, PoseEvent } from "@dock-gateway/client";
import { Text } from "@mantine/core";
import { useEffect, useId, useMemo, useState } from "react";
import { onBeat } from "../clock/beat";
import { RecordedScene } from "../scene/recorded";
import { SceneCanvas } from "../scene/SceneCanvas";
import { describePose } from "../scene/words";
import { Trouble } from "../ui/errors";
import { useAnswer } from "../ui/requests";
import { Section } from "../ui/Section";
import { useWatched } from "./useGoalWatch";

/** How often the words follow the picture (ms). */
const WORDS_MS = 400;
const LEAVE = async () => {};
const NO_GHOST = () => {};

/** Where the robot was at the moment that is marked, and its way until then. Nothing where no poses are stored. */
export default function ReplayMap({ goal }: { goal: AnyGoal }) {
  const { api } = useWatched();
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
  return <Drawn poses={poses} began={Date.parse(goal.created_at)} />;
}

function Drawn({ poses, began }: { poses: readonly PoseEvent[]; began: number }) {
  const { crosshair } = useWatched();
  const wordsId = useId();
  const scene = useMemo(() => new RecordedScene(poses, began), [poses, began]);
  const [words, setWords] = useState("");
  useEffect(() => {
    const seek = () => scene.seek(crosshair.moment);
    const describe = () => {
      const { latest } = scene;
      if (latest !== null)
        setWords(`Robot at ${describePose(latest.robot)}${latest.frame === "odom" ? ", by odometry" : ""}`);
    };
    seek();
    describe();
    const forget = crosshair.subscribe(seek);
    const stop = onBeat(WORDS_MS, describe);
    return () => {
      forget();
      stop();
    };
  }, [scene, crosshair]);
  return (
    <Section title="Map">
      <SceneCanvas scene={scene} placeable={false} describedBy={wordsId} onPlace={LEAVE} onGhost={NO_GHOST} />
      <Text size="sm" id={wordsId} className="tabular" data-testid="replay-map-words">
        {words}
      </Text>
    </Section>
  );
}
