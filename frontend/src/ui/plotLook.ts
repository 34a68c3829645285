import type uPlot from "uplot";

interface PlotColors {
  text: string;
  grid: string;
}

const COLORS: Record<"light" | "dark", PlotColors> = {
  light: { text: "#343a40", grid: "#dee2e6" },
  dark: { text: "#dee2e6", grid: "#424242" },
};

const FONT = "12px system-ui, sans-serif";
const [TICK, GAP] = [6, 4];
/** Room right of the last label's middle, for half of `1:02:05.000`. */
export const LABEL_OVERHANG = 34;

/** How an axis of any plot looks in a colour scheme. */
export function plotAxis(scheme: "light" | "dark"): uPlot.Axis {
  const { text, grid } = COLORS[scheme];
  return {
    stroke: text,
    font: FONT,
    gap: GAP,
    ticks: { stroke: grid, size: TICK },
    grid: { stroke: grid, width: 1 },
  };
}

let canvas: CanvasRenderingContext2D | null | undefined;

/** How wide a vertical axis with these labels is, so that none of them is clipped (CSS pixels). */
export function axisWidth(labels: readonly string[] | null): number {
  canvas ??= document.createElement("canvas").getContext("2d");
  if (canvas === null) return 0;
  canvas.font = FONT;
  const widths = (labels ?? []).map((label) => canvas?.measureText(label).width ?? 0);
  return Math.ceil(Math.max(24, ...widths)) + TICK + GAP + 2;
}
