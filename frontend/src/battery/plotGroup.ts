import "uplot/dist/uPlot.min.css";
import uPlot from "uplot";
import { noPoints, type Points, QUANTITIES, type Quantity } from "../store/batterySeries";
import { fixed } from "../ui/numbers";
import { POINTS, plotAxis } from "../ui/plotData";
import type { Zone } from "../ui/zone";
import { describe } from "./points";
import { formatValue, marks, rangeOf, SHAPES } from "./quantities";
import { formatMark } from "./view";

const PLOT_HEIGHT = 160;
/** Narrower drags are clicks. */
const LEAST_DRAG_PX = 6;

/** Where a quantity is drawn, and where its value at the crosshair is written. */
export type Places = Record<Quantity, { plot: HTMLElement; value: HTMLElement }>;

let groups = 0;

/** The plots of a battery with one crosshair. Draws, and writes its values, outside of React. */
export class PlotGroup {
  readonly #plots: Record<Quantity, uPlot>;
  readonly #places: Places;
  readonly #onMoment: (timeS: number | null) => void;
  #points: Points = noPoints();
  #span: [number, number] = [0, 1];
  /** A button is held down: what is being selected has to keep still. */
  #held = false;

  /**
   * @param onMoment Called with the time at the crosshair (s since 1970), null where there is none.
   * @param onSelect Called with what was dragged across.
   */
  constructor(
    places: Places,
    look: PlotLook,
    handlers: { onMoment: (timeS: number | null) => void; onSelect: (from: number, to: number) => void },
  ) {
    groups += 1;
    const syncKey = `battery-${groups}`;
    this.#places = places;
    this.#onMoment = handlers.onMoment;
    const make = (quantity: Quantity) => {
      const place = places[quantity].plot;
      const size = { width: place.clientWidth, height: PLOT_HEIGHT };
      const events = {
        span: () => this.#span,
        onCursor: (index: number | null) => this.#write(quantity, index),
        onSelect: (from: number, to: number) => {
          const [left, right] = this.#span;
          if (((to - from) / (right - left)) * place.clientWidth >= LEAST_DRAG_PX)
            handlers.onSelect(from, to);
        },
      };
      return new uPlot(plotOptions(quantity, size, look, syncKey, events), undefined, place);
    };
    this.#plots = {
      voltage: make("voltage"),
      percentage: make("percentage"),
      current: make("current"),
      temperature: make("temperature"),
    };
    for (const { over } of Object.values(this.#plots)) over.addEventListener("mousedown", this.#hold);
    window.addEventListener("mouseup", this.#letGo);
  }

  destroy(): void {
    window.removeEventListener("mouseup", this.#letGo);
    for (const plot of Object.values(this.#plots)) plot.destroy();
  }

  readonly #hold = (): void => {
    this.#held = true;
  };

  readonly #letGo = (): void => {
    this.#held = false;
  };

  /** @param span What is shown, s since 1970. */
  draw(points: Points, span: [number, number]): void {
    if (this.#held) return;
    this.#points = points;
    this.#span = span;
    for (const quantity of QUANTITIES) {
      const { mean, min, max } = points.bands[quantity];
      this.#plots[quantity].setData([points.times, max, min, mean]);
      if ((this.#plots[quantity].cursor.left ?? -1) < 0) this.#write(quantity, null);
    }
  }

  resize(): void {
    for (const quantity of QUANTITIES) {
      const width = this.#places[quantity].plot.clientWidth;
      if (width > 0 && width !== this.#plots[quantity].width)
        this.#plots[quantity].setSize({ width, height: PLOT_HEIGHT });
    }
  }

  /** Moves the crosshair by a number of points, to the last one if it is on none. Returns the values there in words. */
  step(by: number): string | null {
    const plot = this.#plots.voltage;
    const { times } = this.#points;
    const [left, right] = this.#span;
    const shown = times.flatMap((time, index) => (time >= left && time <= right ? [index] : []));
    const first = shown[0];
    const last = shown.at(-1);
    if (first === undefined || last === undefined) return null;
    const on = (plot.cursor.left ?? -1) < 0 ? null : (plot.cursor.idx ?? null);
    const index = on === null ? last : Math.min(last, Math.max(first, on + by));
    for (const each of Object.values(this.#plots)) {
      each.setCursor({ left: each.valToPos(times[index] as number, "x"), top: each.over.clientHeight / 2 });
    }
    return QUANTITIES.map((quantity) => formatValue(quantity, this.#points.bands[quantity].mean[index])).join(
      ", ",
    );
  }

  /** Where the crosshair is, 0 (left) to 1 (right); null where there is none. */
  get anchor(): number | null {
    const { cursor, over } = this.#plots.voltage;
    const left = cursor.left ?? -1;
    return left < 0 || over.clientWidth === 0 ? null : left / over.clientWidth;
  }

  #write(quantity: Quantity, index: number | null): void {
    const { times } = this.#points;
    const text = describe(this.#points, quantity, index, this.#span[1]);
    const place = this.#places[quantity].value;
    if (place.textContent !== text) place.textContent = text;
    if (quantity === "voltage") this.#onMoment(index === null ? null : (times[index] ?? null));
  }
}

/** The opacity, in hex, of the band between the lowest and the highest value. */
const BAND_ALPHA = "40";
/** Room for `23:59:59` and some more, in CSS pixels. */
const MARK_SPACE = 80;

interface PlotLook {
  scheme: "light" | "dark";
  zone: Zone;
}

interface PlotEvents {
  /** The span that is shown, s since 1970. */
  span: () => [number, number];
  /** Dragged across, s since 1970. */
  onSelect: (from: number, to: number) => void;
  /** The crosshair is on another point, or on none. */
  onCursor: (index: number | null) => void;
}

/** One quantity over time: its mean, and the band from the least to the most where a point is more than one measurement. */
function plotOptions(
  quantity: Quantity,
  size: { width: number; height: number },
  { scheme, zone }: PlotLook,
  syncKey: string,
  { span, onSelect, onCursor }: PlotEvents,
): uPlot.Options {
  const { decimals, [scheme]: color } = SHAPES[quantity];
  const axis = plotAxis(scheme);
  const edge = { width: 0, points: { show: false } };
  return {
    ...size,
    // Where the marks of the time axis are.
    ...(zone === "utc" ? { tzDate: (timeS: number) => uPlot.tzDate(new Date(timeS * 1000), "UTC") } : {}),
    legend: { show: false },
    padding: [8, 12, 0, 0],
    cursor: {
      drag: { x: true, y: false, setScale: false },
      points: { size: 7 },
      sync: { key: syncKey, setSeries: false },
      // What a double click does is decided outside.
      bind: { dblclick: () => null },
    },
    scales: {
      x: { time: true, range: () => span() },
      y: { range: (_plot, min, max) => rangeOf(quantity, min, max) },
    },
    axes: [
      {
        ...axis,
        space: MARK_SPACE,
        size: 30,
        values: (_plot, splits, _axis, _space, step) => splits.map((split) => formatMark(split, step)),
      },
      {
        ...axis,
        size: 52,
        splits: (_plot, _axis, min, max) => marks(min, max),
        values: (_plot, splits) => splits.map((split) => fixed(split, decimals)),
      },
    ],
    series: [
      {},
      { ...edge, label: "most" },
      { ...edge, label: "least" },
      { label: SHAPES[quantity].name, width: 2, stroke: color, spanGaps: false, points: POINTS },
    ],
    bands: [{ series: [1, 2], fill: `${color}${BAND_ALPHA}` }],
    hooks: {
      setCursor: [(plot) => onCursor((plot.cursor.left ?? -1) < 0 ? null : (plot.cursor.idx ?? null))],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (width <= 0) return;
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          onSelect(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
        },
      ],
    },
  };
}
