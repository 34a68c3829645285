import type uPlot from "uplot";

interface PlotColors {
  text: string;
  grid: string;
}

const COLORS: Record<"light" | "dark", PlotColors> = {
  light: { text: "#343a40", grid: "#dee2e6" },
  dark: { text: "#dee2e6", grid: "#424242" },
};

/** How an axis of any plot looks in a colour scheme. */
export function plotAxis(scheme: "light" | "dark"): uPlot.Axis {
  const { text, grid } = COLORS[scheme];
  return {
    stroke: text,
    font: "12px system-ui, sans-serif",
    ticks: { stroke: grid },
    grid: { stroke: grid, width: 1 },
  };
}
