import uPlot from "uplot";
import { type Crosshair, lastUpTo } from "./crosshair";
import { decimalsOf } from "./numbers";
import {
  axisNumbers,
  axisWidth,
  LABEL_OVERHANG,
  lineWords,
  type PlotBand,
  type PlotLine,
  type PlotSource,
  POINTS,
  plotAxis,
  roomyRange,
} from "./plotData";
import { BACKGROUND, BAND_COLORS, LINE_COLORS } from "./tokens";

/** The least distance between two labels of the x axis (CSS pixels). */
const X_SPACE = 80;
/** A shorter drag is a click. */
const LEAST_DRAG_PX = 4;
const BAND_FONT_PX = 11;

/** Where a line is drawn, and where its value stands. */
export interface PlotPlace {
  plot: HTMLElement;
  value: HTMLElement;
}

interface StackOptions {
  source: PlotSource;
  lines: readonly PlotLine[];
  height: number;
  scheme: "light" | "dark";
  crosshair: Crosshair;
  formatX: (x: number, decimals: number) => string;
  bands: () => readonly PlotBand[];
  /** How far the x axis goes at least. */
  least: () => number;
  onZoom: (zoomed: boolean) => void;
  /** Clicked at that point of the source. */
  onPick: (x: number) => void;
}

/** Lines below each other, each with a scale of its own, over one x axis and under one crosshair. */
export class StackedPlots {
  readonly #plots: uPlot[];
  #data: [number[], ...(number | null)[][]] = [[]];
  #version = -1;
  #zoomed: [number, number] | null = null;
  /** The width of the y axis, the same for all plots so that they are in line. */
  #axisWidth = 0;
  readonly #axisWidths: number[];
  /** The plot that the pointer is on: uPlot moves its cursor itself. */
  #under: uPlot | null = null;
  readonly #forget: () => void;

  constructor(
    private readonly places: readonly PlotPlace[],
    private readonly options: StackOptions,
  ) {
    this.#axisWidths = options.lines.map(() => 0);
    this.#plots = options.lines.map((_, index) => this.#make(index));
    this.#forget = options.crosshair.subscribe(this.#mark);
    this.draw();
  }

  destroy(): void {
    this.#forget();
    if (this.#under !== null) this.options.crosshair.point(null);
    for (const plot of this.#plots) plot.destroy();
    this.#plots.length = 0;
  }

  /** Draws what is new. */
  draw(): void {
    const { source } = this.options;
    if (this.#version === source.version) return;
    this.#version = source.version;
    this.#data = source.read();
    this.#show();
  }

  /** Draws again, as after a change of the bands. */
  redraw(): void {
    this.#show();
  }

  resize(): void {
    for (const [index, plot] of this.#plots.entries()) {
      const width = this.places[index]?.plot.clientWidth ?? 0;
      if (width > 0 && width !== plot.width) plot.setSize({ width, height: plot.height });
    }
    queueMicrotask(this.#mark);
  }

  showAll(): void {
    this.#zoom(null);
  }

  #zoom(span: [number, number] | null): void {
    this.#zoomed = span;
    this.options.onZoom(span !== null);
    this.#show();
  }

  #show(): void {
    const [times, ...values] = this.#data;
    for (const [index, plot] of this.#plots.entries()) plot.setData([times, values[index] ?? []]);
    // After what setData has put off until then.
    queueMicrotask(this.#mark);
  }

  #span(): [number, number] {
    if (this.#zoomed !== null) return this.#zoomed;
    const [times] = this.#data;
    const first = Math.min(0, times[0] ?? 0);
    return [first, Math.max(first + 1e-3, times.at(-1) ?? 0, this.options.least())];
  }

  /** The point of the source nearest to an x. */
  #nearest(x: number): number | null {
    const [times] = this.#data;
    const before = lastUpTo(x, times.length, (index) => times[index] ?? 0);
    const [left, right] = [times[before], times[before + 1]];
    if (left === undefined || right === undefined) return left ?? right ?? null;
    return x - left <= right - x ? left : right;
  }

  /** Puts the crosshair where it belongs, and writes each line's value there, else its latest. */
  readonly #mark = (): void => {
    const { crosshair, lines } = this.options;
    const { moment } = crosshair;
    const [times, ...values] = this.#data;
    const at =
      moment === null
        ? times.length - 1
        : lastUpTo(moment + 1e-6, times.length, (index) => times[index] ?? 0);
    for (const [index, plot] of this.#plots.entries()) {
      if (plot !== this.#under) {
        const left = moment === null ? -10 : plot.valToPos(moment, "x");
        plot.setCursor({ left, top: moment === null ? -10 : plot.over.clientHeight / 2 });
      }
      const [place, line] = [this.places[index], lines[index]];
      const value = values[index]?.[at] ?? null;
      const text = value === null || line === undefined ? "–" : lineWords(line, value);
      if (place !== undefined && place.value.textContent !== text) place.value.textContent = text;
    }
  };

  #make(index: number): uPlot {
    const { lines, height, scheme, formatX, crosshair, onPick } = this.options;
    const place = this.places[index]?.plot as HTMLElement;
    const axis = plotAxis(scheme);
    const options: uPlot.Options = {
      width: place.clientWidth,
      height,
      legend: { show: false },
      padding: [8, LABEL_OVERHANG, 0, 0],
      cursor: {
        y: false,
        drag: { x: true, y: false, setScale: false },
        points: { size: 7 },
        bind: {
          dblclick: () => () => {
            this.#zoom(null);
            return null;
          },
        },
      },
      scales: {
        x: { time: false, range: () => this.#span() },
        y: { range: (_plot, min, max) => roomyRange(min, max, lines[index]?.least) },
      },
      axes: [
        {
          ...axis,
          space: X_SPACE,
          size: 30,
          values: (_plot, splits, _axis, _space, step) =>
            splits.map((split) => formatX(split, decimalsOf(step))),
        },
        {
          ...axis,
          size: (_plot, labels) => this.#widthFor(index, labels),
          values: (_plot, splits, _axis, _space, step) => axisNumbers(splits, step),
        },
      ],
      series: [
        {},
        {
          label: lines[index]?.label ?? "",
          stroke: LINE_COLORS[scheme][index % LINE_COLORS[scheme].length] ?? LINE_COLORS[scheme][0],
          width: 2,
          spanGaps: false,
          points: POINTS,
        },
      ],
      hooks: {
        drawClear: [(plot) => this.#fillBands(plot)],
        drawAxes: index === 0 ? [(plot) => this.#nameBands(plot)] : [],
        draw: [() => this.#align()],
        setSelect: [
          (plot) => {
            const { left, width } = plot.select;
            if (width < LEAST_DRAG_PX) return;
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            this.#zoom([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
          },
        ],
      },
    };
    const plot = new uPlot(options, undefined, place);
    const { over } = plot;
    let pressed = 0;
    over.addEventListener("mousemove", (event) => {
      this.#under = plot;
      crosshair.point(this.#nearest(plot.posToVal(event.offsetX, "x")));
    });
    over.addEventListener("mouseleave", () => {
      this.#under = null;
      crosshair.point(null);
      this.#mark();
    });
    over.addEventListener("mousedown", (event) => {
      pressed = event.clientX;
    });
    over.addEventListener("click", (event) => {
      const x = this.#nearest(plot.posToVal(event.offsetX, "x"));
      if (x !== null && Math.abs(event.clientX - pressed) < LEAST_DRAG_PX) onPick(x);
    });
    return plot;
  }

  #widthFor(index: number, labels: readonly string[] | null): number {
    this.#axisWidth = Math.max(this.#axisWidth, axisWidth(labels));
    this.#axisWidths[index] = this.#axisWidth;
    return this.#axisWidth;
  }

  /** What was drawn before another axis became wider is drawn once more. */
  #align(): void {
    for (const [index, plot] of this.#plots?.entries() ?? [])
      if ((this.#axisWidths[index] ?? 0) < this.#axisWidth) plot.redraw(false, true);
  }

  /** The bands in sight, in canvas pixels. */
  *#bandsOn(plot: uPlot) {
    const { left, width } = plot.bbox;
    const place = (x: number) => Math.min(left + width, Math.max(left, plot.valToPos(x, "x", true)));
    for (const { from, to, label, color } of this.options.bands()) {
      const start = place(from);
      const end = to === null ? left + width : place(to);
      if (end > start) yield { label, color, start, width: end - start };
    }
  }

  #fillBands(plot: uPlot): void {
    const { ctx, bbox } = plot;
    ctx.save();
    for (const { color, start, width } of this.#bandsOn(plot)) {
      ctx.fillStyle = BAND_COLORS[this.options.scheme][color];
      ctx.fillRect(start, bbox.top, width, bbox.height);
    }
    ctx.restore();
  }

  /** Names the bands that have room for that, over the grid, whose lines would strike the names out. */
  #nameBands(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const room = 4 * devicePixelRatio;
    ctx.save();
    ctx.font = `${BAND_FONT_PX * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textBaseline = "top";
    ctx.textAlign = "left";
    ctx.lineWidth = room;
    ctx.lineJoin = "round";
    ctx.strokeStyle = BACKGROUND[this.options.scheme];
    ctx.fillStyle = plotAxis(this.options.scheme).stroke as string;
    for (const { label, start, width } of this.#bandsOn(plot)) {
      if (ctx.measureText(label).width + 2 * room > width) continue;
      ctx.strokeText(label, start + room, bbox.top + room);
      ctx.fillText(label, start + room, bbox.top + room);
    }
    ctx.restore();
  }
}
