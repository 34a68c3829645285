import type { LiveGoal } from "@dock-gateway/client";
import { Button, Group, SegmentedControl, Text } from "@mantine/core";
import { useReducedMotion } from "@mantine/hooks";
import { useEffect, useRef, useState } from "react";
import { useSearchParams } from "react-router";
import { BEAT_MS, onBeat } from "../clock/beat";
import { bandsOf } from "../goal/timeline";
import { Section } from "../ui/Section";
import { formatElapsed } from "../ui/time";
import { useLatest } from "../ui/useLatest";
import classes from "./goalPage.module.css";
import { useHeldMoment, useTimeline, useWatched } from "./useGoalWatch";

/** The moment of the replay is this parameter of the address (s since the goal began). */
const AT = "at";
const SLOW_MS = 1000;
/** A scrubber that moves writes to the address when it rests. */
const REST_MS = 300;

/** Goes through a goal that has ended: what the plots, the table and the timeline mark, and the message that is shown. */
export function Replay({ goal }: { goal: LiveGoal }) {
  const { crosshair } = useWatched();
  const [parameters, setParameters] = useSearchParams();
  const [playing, setPlaying] = useState(false);
  const [speed, setSpeed] = useState<Speed>(1);
  const reducedMotion = useReducedMotion();
  const moment = useHeldMoment();
  const start = Date.parse(goal.created_at);
  const length = Math.max(0, (Date.parse(goal.finished_at ?? goal.updated_at) - start) / 1000);
  const stage = useStageAt(goal, moment);
  const address = parameters.get(AT);
  const write = useLatest((at: number | null) => {
    if (at === null) parameters.delete(AT);
    else parameters.set(AT, momentText(at));
    setParameters(parameters, { replace: true });
  });

  useEffect(() => crosshair.hold(momentIn(address, length)), [crosshair, address, length]);

  useEffect(() => {
    if (!playing) return;
    let before = performance.now();
    return onBeat(reducedMotion ? SLOW_MS : BEAT_MS, () => {
      const now = performance.now();
      const next = (crosshair.held ?? 0) + ((now - before) / 1000) * speed;
      before = now;
      crosshair.hold(Math.min(length, next));
      if (next < length) return;
      setPlaying(false);
      write.current(length);
    });
  }, [playing, speed, length, reducedMotion, crosshair]);

  const rest = useRef<ReturnType<typeof setTimeout>>(undefined);
  useEffect(() => () => clearTimeout(rest.current), []);
  const scrub = (to: number) => {
    setPlaying(false);
    crosshair.hold(to);
    clearTimeout(rest.current);
    rest.current = setTimeout(() => write.current(to), REST_MS);
  };
  const toggle = () => {
    clearTimeout(rest.current);
    if (playing) write.current(crosshair.held);
    else crosshair.hold(playFrom(crosshair.held, length));
    setPlaying(!playing);
  };
  const leave = () => {
    clearTimeout(rest.current);
    setPlaying(false);
    crosshair.hold(null);
    write.current(null);
  };
  const at = moment ?? 0;
  const words = `${formatElapsed(at, 1)}${stage === null ? "" : `, ${stage}`}`;
  return (
    <Section title="Replay">
      <div className={classes.replay}>
        <Group gap="xs" wrap="nowrap">
          <Button variant="default" size="compact-md" miw={76} onClick={toggle}>
            {playing ? "Pause" : "Play"}
          </Button>
          <SegmentedControl
            aria-label="Speed"
            size="xs"
            value={String(speed)}
            onChange={(value) => setSpeed(Number(value) as Speed)}
            data={SPEEDS.map((each) => ({ value: String(each), label: `${each}×` }))}
          />
        </Group>
        <input
          type="range"
          className={classes.scrubber}
          aria-label="Moment of the goal"
          aria-valuetext={words}
          min={0}
          max={length}
          step={stepOf(length)}
          value={at}
          onChange={(event) => scrub(Number(event.currentTarget.value))}
        />
        <Text size="sm" className="tabular" data-testid="replay-moment">
          {moment === null ? "Not replaying" : words}
        </Text>
        <Button variant="default" size="compact-md" disabled={moment === null} onClick={leave}>
          End replay
        </Button>
      </div>
    </Section>
  );
}

/** The stage that a goal was in at a moment. */
function useStageAt(goal: LiveGoal, moment: number | null): string | null {
  const { entries } = useTimeline(goal);
  if (moment === null) return null;
  const bands = bandsOf(entries, Date.parse(goal.created_at));
  return bands.findLast(({ from, to }) => from <= moment && (to === null || moment < to))?.label ?? null;
}

const SPEEDS = [1, 4, 16] as const;

type Speed = (typeof SPEEDS)[number];

/** The moment (s) that an address holds, within a goal of that length; null where it holds none. */
export function momentIn(text: string | null, length: number): number | null {
  const moment = text === null || text.trim() === "" ? Number.NaN : Number(text);
  return Number.isNaN(moment) ? null : Math.min(length, Math.max(0, moment));
}

/** Writes a moment for the address, to the millisecond. */
export function momentText(moment: number): string {
  return String(Number(moment.toFixed(3)));
}

/** One step of the arrow keys (s): a few hundred of them are the goal. */
export function stepOf(length: number): number {
  return length <= 60 ? 0.1 : Math.ceil(length / 600);
}

/** Where it plays to: from the beginning again at the end. */
export function playFrom(moment: number | null, length: number): number {
  return moment === null || moment >= length ? 0 : moment;
}
