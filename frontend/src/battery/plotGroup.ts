import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { noPoints, type Points, QUANTITIES, type Quantity } from "../store/batterySeries";
import { type PlotLook, plotOptions } from "./plotOptions";
import { describe } from "./points";
import { formatValue } from "./quantities";

export const PLOT_HEIGHT = 160;
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

  /** Moves the crosshair by so many points; onto the last one that is shown where there is none. Returns it in words. */
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
