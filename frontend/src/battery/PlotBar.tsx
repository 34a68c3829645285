import { Badge, Button, Group, SegmentedControl, Text } from "@mantine/core";
import type { RefObject } from "react";
import { useAtTime } from "../clock/clock";
import { FreshnessBadge } from "../fleet/badges";
import { useFreshness } from "../store/freshness";
import { Tool } from "../ui/Tool";
import { useZone } from "../ui/zone";
import classes from "./BatteryPlots.module.css";
import { edges, formatMoment, formatSpan, pan, pause, type View } from "./view";

const SPANS = [300, 3600, 86_400, 604_800];
const ZOOM_STEP = 2;
const HALF = 0.5;

interface PlotBarProps {
  view: View;
  loading: boolean;
  /** Where the time at the crosshair is written. */
  momentRef: RefObject<HTMLSpanElement | null>;
  onChange: (next: (view: View, now: number) => View) => void;
  onZoom: (factor: number) => void;
}

/** Which part of time is shown, and how to get to another one. */
export function PlotBar({ view, loading, momentRef, onChange, onZoom }: PlotBarProps) {
  useZone();
  const following = view.endS === null;
  const range = useAtTime((ms) => rangeWords(view, ms / 1000));
  return (
    <div className={classes.bar}>
      <Group gap="xs">
        <SegmentedControl
          aria-label="The last"
          value={following ? String(view.spanS) : ""}
          onChange={(span) => onChange(() => ({ spanS: Number(span), endS: null }))}
          data={SPANS.map((span) => ({ label: formatSpan(span), value: String(span) }))}
        />
        <Group gap={4}>
          <Tool name="Earlier" onClick={() => onChange((before, at) => pan(before, -HALF, at))}>
            <path d="M15 5l1.5 1.5L11 12l5.5 5.5L15 19l-7-7z" />
          </Tool>
          <Tool
            name="Later"
            disabled={following}
            why="Later: this is now"
            onClick={() => onChange((before, at) => pan(before, HALF, at))}
          >
            <path d="M9 5L7.5 6.5 13 12l-5.5 5.5L9 19l7-7z" />
          </Tool>
          <Tool name="Closer" onClick={() => onZoom(ZOOM_STEP)}>
            <path d="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6V5Z" />
          </Tool>
          <Tool name="Farther" onClick={() => onZoom(1 / ZOOM_STEP)}>
            <path d="M5 11h14v2H5v-2Z" />
          </Tool>
        </Group>
        <Button
          variant={following ? "default" : "filled"}
          size="sm"
          miw={92}
          onClick={() =>
            onChange((before, at) => (following ? pause(before, at) : { ...before, endS: null }))
          }
        >
          {following ? "Pause" : "Go live"}
        </Button>
      </Group>
      <Group gap="xs" className={classes.shown}>
        <Shown following={following} loading={loading} />
        <Text size="sm" className="tabular" data-testid="plot-range">
          {range}
        </Text>
        <Text size="sm" fw={600} className={`tabular ${classes.moment}`} component="span">
          <span ref={momentRef} data-testid="plot-moment" />
        </Text>
      </Group>
    </div>
  );
}

function rangeWords(view: View, now: number): string {
  if (view.endS === null) return `Last ${formatSpan(view.spanS)}`;
  const { from, to } = edges(view, now);
  return `${formatMoment(from, now)} to ${formatMoment(to, now)}`;
}

function Shown({ following, loading }: { following: boolean; loading: boolean }) {
  const freshness = useFreshness("battery");
  if (freshness === "offline") return <FreshnessBadge freshness={freshness} />;
  if (loading) return <Badge color="gray.7">Reading …</Badge>;
  return following ? <FreshnessBadge freshness={freshness} /> : <Badge color="blue">Paused</Badge>;
}
