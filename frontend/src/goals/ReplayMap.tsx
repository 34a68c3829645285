import type { LiveGoal, PoseEvent } from "@dock-gateway/client";
import { Text } from "@mantine/core";
import { useEffect, useId, useMemo, useState } from "react";
import { onBeat } from "../clock/beat";
import { Parts } from "../extension/context";
import type { ReplayLayer } from "../extension/extension";
import { RecordedScene } from "../scene/recorded";
import { SceneCanvas } from "../scene/SceneCanvas";
import { describePose } from "../scene/words";
import { Trouble } from "../ui/errors";
import { Section } from "../ui/Section";
import { useWatched } from "./useGoalWatch";
import { usePoses } from "./usePoses";

/** How often the words follow the picture (ms). */
const WORDS_MS = 400;
const LEAVE = async () => {};
const NO_GHOST = () => {};

/** Where the robot was at the moment that is marked, and its way until then. Nothing where no poses are stored. */
export default function ReplayMap({ goal }: { goal: LiveGoal }) {
  const [layer, setLayer] = useState<ReplayLayer | null>(null);
  const { data: poses = [], error, refetch } = usePoses(goal);
  if (error !== null)
    return <Trouble what="The map could not be loaded" error={error} onRetry={() => void refetch()} />;
  if (poses.length === 0) return null;
  return (
    <>
      <Parts at="replay" goal={goal} onLayer={setLayer} quiet />
      <Drawn poses={poses} began={Date.parse(goal.created_at)} layer={layer} />
    </>
  );
}

interface DrawnProps {
  poses: readonly PoseEvent[];
  /** When the goal began (ms). */
  began: number;
  /** What an extension adds; null for nothing. */
  layer: ReplayLayer | null;
}

function Drawn({ poses, began, layer }: DrawnProps) {
  const { crosshair } = useWatched();
  const wordsId = useId();
  const scene = useMemo(() => new RecordedScene(poses, began), [poses, began]);
  const seen = layer?.scene ?? null;
  const around = useMemo(
    () =>
      seen === null
        ? undefined
        : { layers: [seen], docks: [], frameIn: () => null, blocked: false, idle: false },
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
      setWords([where, ...(layer?.readings(crosshair.moment) ?? [])].join("; "));
    };
    seek();
    describe();
    const forget = crosshair.subscribe(seek);
    const stop = onBeat(WORDS_MS, describe);
    return () => {
      forget();
      stop();
    };
  }, [scene, seen, layer, crosshair]);
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
