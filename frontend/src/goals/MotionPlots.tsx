import type { LiveGoal } from "@dock-gateway/client";
import { Skeleton } from "@mantine/core";
import { Suspense, useMemo } from "react";
import { bandsOf } from "../goal/timeline";
import { lazyPart } from "../ui/lazyPart";
import type { Digits } from "../ui/numbers";
import { Section } from "../ui/Section";
import { formatElapsed } from "../ui/time";
import { knowsDock, MotionSource, motionOf } from "./motion";
import { useTimeline, useWatched } from "./useGoalWatch";
import { usePoses } from "./usePoses";

const PlotStack = lazyPart(() => import("../ui/PlotStack"));

const HEIGHT = 150;
const CENTIMETERS: Digits = { decimals: 2, magnitude: 0 };
const DISTANCE = { label: "Distance to the dock", unit: "m", digits: CENTIMETERS, least: [0, 0.1] } as const;
const VELOCITY = {
  label: "Velocity forward",
  unit: "m/s",
  digits: CENTIMETERS,
  least: [-0.05, 0.05],
} as const;

/** How the robot of a docking or undocking goal moved, which tells first why it failed. Nothing where no poses are stored. */
export function MotionPlots({ goal }: { goal: LiveGoal }) {
  const { crosshair } = useWatched();
  const { entries } = useTimeline(goal);
  const { data: poses } = usePoses(goal);
  const start = Date.parse(goal.created_at);
  const end = Date.parse(goal.finished_at ?? goal.updated_at);
  const motion = useMemo(() => motionOf(poses ?? [], start, end), [poses, start, end]);
  const source = useMemo(() => new MotionSource(motion), [motion]);
  const bands = useMemo(() => bandsOf(entries, start), [entries, start]);
  const lines = useMemo(() => (knowsDock(motion.distances) ? [DISTANCE, VELOCITY] : [VELOCITY]), [motion]);
  if (motion.times.length < 2) return null;
  return (
    <Section title="Motion">
      <Suspense fallback={<Skeleton height={lines.length * (HEIGHT + 38)} />}>
        <PlotStack
          source={source}
          lines={lines}
          labels={lines.map(({ label, unit }) => `${label} over time, in ${unit}`)}
          tools={[]}
          bands={bands}
          least={(end - start) / 1000}
          crosshair={crosshair}
          formatX={formatElapsed}
          onPick={NOTHING}
          height={HEIGHT}
        />
      </Suspense>
    </Section>
  );
}

const NOTHING = () => {};
