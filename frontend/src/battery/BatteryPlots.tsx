import {
  Badge,
  Button,
  Group,
  SegmentedControl,
  Text,
  useComputedColorScheme,
  VisuallyHidden,
} from "@mantine/core";
import { useReducedMotion } from "@mantine/hooks";
import {
  type KeyboardEvent,
  type RefObject,
  useCallback,
  useEffect,
  useId,
  useMemo,
  useRef,
  useState,
} from "react";
import { titleOf } from "../api/errors";
import { onBeat, steadyNow } from "../clock/beat";
import { useAtTime } from "../clock/clock";
import { FreshnessBadge } from "../fleet/badges";
import { QUANTITIES, type Quantity } from "../store/batterySeries";
import { useFreshness, useLive, useServices } from "../store/context";
import { watchSight } from "../ui/sight";
import { Tool } from "../ui/Tool";
import { formatter } from "../ui/time";
import { useLatest } from "../ui/useLatest";
import { useZone } from "../ui/zone";
import classes from "./BatteryPlots.module.css";
import { drainWords } from "./drain";
import { type Places, PlotGroup } from "./plotGroup";
import { join, usePast } from "./points";
import { SHAPES } from "./quantities";
import { between, edges, formatMoment, formatSpan, LIVE, pan, pause, type View, zoom } from "./view";

/** New messages are drawn no more often than this. */
const REDRAW_MS = 200;
/** How wide a plot is, about. */
const PIXELS = 600;
/** Between two redraws without messages, as time moves on. */
const SCROLL_MS = 1000;
/** Out of sight, as for a picture of the whole page. */
const UNSEEN_MS = 5000;
const ZOOM_STEP = 2;
const dayAndMonth = formatter({ day: "numeric", month: "short" });
const PAN_STEP = 0.25;

/** What the battery was over time: live, paused, or any part of the past. */
export default function BatteryPlots() {
  const { store, series } = useServices();
  const live = useLive();
  const scheme = useComputedColorScheme("light");
  const zone = useZone();
  const reducedMotion = useReducedMotion();
  const [view, setView] = useState<View>(LIVE);
  const past = usePast(view);
  const drain = useMemo(() => drainWords(past.points, (timeS) => dayAndMonth(timeS * 1000)), [past.points]);
  const latest = useLatest({ view, past });
  const plots = useRef<Partial<Record<Quantity, HTMLDivElement | null>>>({});
  const values = useRef<Partial<Record<Quantity, HTMLSpanElement | null>>>({});
  const moment = useRef<HTMLSpanElement>(null);
  const frame = useRef<HTMLDivElement>(null);
  const group = useRef<PlotGroup | null>(null);
  const [said, setSaid] = useState("");
  const hintId = useId();

  const now = useCallback(() => store.gatewayNow() / 1000, [store]);
  const change = useCallback(
    (next: (view: View, now: number) => View) => setView((before) => next(before, now())),
    [now],
  );
  const zoomBy = useCallback(
    (factor: number) => change((before, at) => zoom(before, factor, group.current?.anchor ?? 1, at)),
    [change],
  );

  const draw = useCallback(() => {
    const { view, past } = latest.current;
    const { from, to } = edges(view, now());
    group.current?.draw(join(past.points, series.points, past.resolutionS), [from, to]);
  }, [series, now]);

  useEffect(() => {
    const places = {} as Places;
    for (const quantity of QUANTITIES) {
      const [plot, value] = [plots.current[quantity], values.current[quantity]];
      // Without a width there is nothing to draw on, as in a test without a layout.
      if (!plot || !value || plot.clientWidth === 0) return;
      places[quantity] = { plot, value };
    }
    const made = new PlotGroup(
      places,
      { scheme, zone },
      {
        onMoment: (timeS) => {
          if (moment.current !== null)
            moment.current.textContent = timeS === null ? "" : formatMoment(timeS, now());
        },
        onSelect: (from, to) => change((_, at) => between(from, to, at)),
      },
    );
    group.current = made;
    draw();
    const resized = new ResizeObserver(() => made.resize());
    resized.observe(places.voltage.plot);
    return () => {
      resized.disconnect();
      made.destroy();
      group.current = null;
    };
  }, [scheme, zone, change, draw, now]);

  // biome-ignore lint/correctness/useExhaustiveDependencies: what is drawn is read from `latest`
  useEffect(draw, [draw, view, past]);

  useEffect(() => {
    const element = frame.current;
    if (element === null || view.endS !== null || !live) return;
    let drawnVersion = series.version;
    let drawnAt = steadyNow();
    let inSight = true;
    const renew = () => {
      const age = steadyNow() - drawnAt;
      if (inSight ? series.version === drawnVersion && age < SCROLL_MS : age < UNSEEN_MS) return;
      drawnVersion = series.version;
      drawnAt = steadyNow();
      draw();
    };
    const unwatch = watchSight(element, (now) => {
      inSight = now;
      renew();
    });
    const stop = onBeat(reducedMotion ? SCROLL_MS : redrawMs(view), renew);
    return () => {
      unwatch();
      stop();
    };
  }, [view, live, series, draw, reducedMotion]);

  useEffect(() => {
    const element = frame.current;
    if (element === null) return;
    /** The wheel alone scrolls the page; with Ctrl, as a pinch on a trackpad sends it, it zooms, and sideways it goes back and forth. */
    const turn = (event: WheelEvent) => {
      const sideways = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
      if (event.ctrlKey || event.metaKey) zoomBy(Math.exp(-event.deltaY / 300));
      else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY))
        change((before, at) => pan(before, sideways / element.clientWidth, at));
      else return;
      event.preventDefault();
    };
    element.addEventListener("wheel", turn, { passive: false });
    return () => element.removeEventListener("wheel", turn);
  }, [change, zoomBy]);

  const step = (by: number) => {
    const words = group.current?.step(by) ?? null;
    setSaid(
      words === null ? "Nothing was measured in this time." : `${moment.current?.textContent}: ${words}`,
    );
  };
  const press = (event: KeyboardEvent) => {
    if (event.altKey || event.ctrlKey || event.metaKey || event.target !== event.currentTarget) return;
    const steps: Record<string, () => void> = {
      ArrowLeft: () => (event.shiftKey ? change((before, at) => pan(before, -PAN_STEP, at)) : step(-1)),
      ArrowRight: () => (event.shiftKey ? change((before, at) => pan(before, PAN_STEP, at)) : step(1)),
      PageUp: () => change((before, at) => pan(before, -1, at)),
      PageDown: () => change((before, at) => pan(before, 1, at)),
      "+": () => zoomBy(ZOOM_STEP),
      "=": () => zoomBy(ZOOM_STEP),
      "-": () => zoomBy(1 / ZOOM_STEP),
      "0": () => setView(LIVE),
      " ": () =>
        change((before, at) => (before.endS === null ? pause(before, at) : { ...before, endS: null })),
    };
    const act = steps[event.key];
    if (act === undefined) return;
    event.preventDefault();
    act();
  };

  return (
    <>
      <PlotBar view={view} loading={past.loading} momentRef={moment} onChange={change} onZoom={zoomBy} />
      <div
        ref={frame}
        className={classes.grid}
        role="application"
        aria-label="Battery over time: voltage, percentage, current and temperature"
        aria-describedby={hintId}
        // biome-ignore lint/a11y/noNoninteractiveTabindex: an application takes keys
        tabIndex={0}
        onKeyDown={press}
        onDoubleClick={() => zoomBy(1 / ZOOM_STEP)}
        data-testid="battery-plots"
      >
        {QUANTITIES.map((quantity) => (
          <figure key={quantity} className={classes.figure}>
            <figcaption className={classes.caption}>
              <span className={classes.mark} style={{ background: SHAPES[quantity][scheme] }} />
              {SHAPES[quantity].name}{" "}
              <span
                className={classes.value}
                data-testid={`value-${quantity}`}
                ref={(element) => {
                  values.current[quantity] = element;
                }}
              />
            </figcaption>
            <div
              className={classes.plot}
              ref={(element) => {
                plots.current[quantity] = element;
              }}
            />
          </figure>
        ))}
      </div>
      <VisuallyHidden role="status">{said}</VisuallyHidden>
      {drain !== null && (
        <Text size="sm" fw={600} data-testid="battery-drain">
          {drain}
        </Text>
      )}
      <Text size="sm" c="dimmed" id={hintId}>
        Drag across a plot to look closer, double-click to look at more. With the keyboard: ← → the crosshair,
        with Shift back and forth in time, + − closer and farther, Space pause, 0 live.
      </Text>
      {past.error !== null && (
        <Text size="sm" role="status">
          <strong>The past cannot be read:</strong> {titleOf(past.error)} ({past.error.code}). What comes in
          now is drawn all the same.
        </Text>
      )}
    </>
  );
}

/** The time after which the plots have moved by about a pixel, in whole beats. */
function redrawMs({ spanS }: View): number {
  const beats = Math.round((spanS * 1000) / PIXELS / REDRAW_MS);
  return Math.min(SCROLL_MS, Math.max(1, beats) * REDRAW_MS);
}

const SPANS = [300, 3600, 86_400, 604_800];
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
function PlotBar({ view, loading, momentRef, onChange, onZoom }: PlotBarProps) {
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
          <Tool
            name="Earlier"
            onClick={() => onChange((before, at) => pan(before, -HALF, at))}
            path="M15 5l1.5 1.5L11 12l5.5 5.5L15 19l-7-7z"
          />
          <Tool
            name="Later"
            disabled={following}
            title={following ? "Later: this is now" : "Later"}
            onClick={() => onChange((before, at) => pan(before, HALF, at))}
            path="M9 5L7.5 6.5 13 12l-5.5 5.5L9 19l7-7z"
          />
          <Tool name="Closer" onClick={() => onZoom(ZOOM_STEP)} path="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6V5Z" />
          <Tool name="Farther" onClick={() => onZoom(1 / ZOOM_STEP)} path="M5 11h14v2H5v-2Z" />
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
