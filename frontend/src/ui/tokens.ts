// The scale of the dashboard: letters, weights, spaces and colours. tokens.mjs, a part of `npm run lint`, sees to it that
// stylesheets use nothing else; what is drawn on a canvas takes its colours from here, too.
import type { MantineColorsTuple } from "@mantine/core";

export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif";
export const MONOSPACE = "ui-monospace, 'SF Mono', Menlo, Consolas, 'DejaVu Sans Mono', monospace";

/** Font sizes, as in `var(--mantine-font-size-sm)` and `var(--mantine-h3-font-size)`: 12, 14, 16, 18 px, and titles. */
export const SIZES = [
  "font-size-xs",
  "font-size-sm",
  "font-size-md",
  "font-size-lg",
  "h4-font-size",
  "h3-font-size",
  "h2-font-size",
];

/** Text, what stands out, titles. */
export const WEIGHTS = [400, 600, 700];

/** Spaces between things and in them, in rem, beside Mantine's own: xs 0.625, sm 0.75, md 1, lg 1.25, xl 2. */
export const SPACES = [0.0625, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 1, 1.25, 1.5, 2];

/** Mantine's own, but for the last shade: white text can be read on it, and it can be read on the first one. */
export const GREEN: MantineColorsTuple = [
  "#ebfbee",
  "#d3f9d8",
  "#b2f2bb",
  "#8ce99a",
  "#69db7c",
  "#51cf66",
  "#40c057",
  "#37b24d",
  "#2f9e44",
  "#237032",
];

/** The same. */
export const ORANGE: MantineColorsTuple = [
  "#fff4e6",
  "#ffe8cc",
  "#ffd8a8",
  "#ffc078",
  "#ffa94d",
  "#ff922b",
  "#fd7e14",
  "#f76707",
  "#e8590c",
  "#a33a00",
];

interface PlotColors {
  text: string;
  grid: string;
}

/** Axes and grids of plots. */
export const PLOT_COLORS: Record<"light" | "dark", PlotColors> = {
  light: { text: "#343a40", grid: "#dee2e6" },
  dark: { text: "#dee2e6", grid: "#424242" },
};

/** The colors of lines, with the same contrast to the background. */
export const LINE_COLORS = {
  light: ["#1864ab", "#a61e4d", "#2b8a3e", "#862e9c", "#0b7285", "#d9480f"],
  dark: ["#74c0fc", "#ffa8c5", "#8ce99a", "#e599f7", "#66d9e8", "#ffc078"],
} as const;

/** The color of the card that a plot is on. */
export const BACKGROUND = { light: "#ffffff", dark: "#242424" } as const;

/** The colors of bands behind the lines, faint enough to read the lines. */
export const BAND_COLORS = {
  light: { gray: "#868e9624", cyan: "#15aabf24", blue: "#228be624", green: "#40c05728", orange: "#fd7e1430" },
  dark: { gray: "#ced4da22", cyan: "#3bc9db2a", blue: "#4dabf72e", green: "#69db7c2a", orange: "#ffa94d36" },
} as const;

/** The lines of what a battery reports. */
export const BATTERY_COLORS = {
  voltage: { light: "#a61e4d", dark: "#ffa8c5" },
  percentage: { light: "#1864ab", dark: "#74c0fc" },
  current: { light: "#5f3dc4", dark: "#b197fc" },
  temperature: { light: "#a33a00", dark: "#ffc078" },
} as const;

export interface SceneColors {
  grid: string;
  axis: string;
  text: string;
  /** The numbers along the edges. */
  metres: string;
  robot: string;
  robotEdge: string;
  onRobot: string;
  trail: string;
  dock: string;
  dockEdge: string;
  contact: string;
  staging: string;
  marker: string;
  beam: string;
  ghost: string;
  scan: string;
  obstacle: string;
  path: string;
  /** Around texts. */
  halo: string;
}

export const SCENE_COLORS: Record<"light" | "dark", SceneColors> = {
  light: {
    grid: "#eef0f2",
    axis: "#ced4da",
    text: "#343a40",
    metres: "#5c636a",
    robot: "#1864ab",
    robotEdge: "#0b3d6b",
    onRobot: "#ffffff",
    trail: "#4dabf7",
    dock: "#495057",
    dockEdge: "#212529",
    contact: "#237032",
    staging: "#862e9c",
    marker: "#c2255c",
    beam: "#f08c00",
    ghost: "#1864ab",
    scan: "#e8590c",
    obstacle: "#c92a2a",
    path: "#0b7285",
    halo: "#ffffffd9",
  },
  dark: {
    grid: "#303030",
    axis: "#4a4a4a",
    text: "#dee2e6",
    metres: "#adb5bd",
    robot: "#4dabf7",
    robotEdge: "#a5d8ff",
    onRobot: "#12202e",
    trail: "#339af0",
    dock: "#868e96",
    dockEdge: "#ced4da",
    contact: "#69db7c",
    staging: "#da77f2",
    marker: "#ff8fb1",
    beam: "#ffc078",
    ghost: "#a5d8ff",
    scan: "#ff922b",
    obstacle: "#ff6b6b",
    path: "#3bc9db",
    halo: "#242424d9",
  },
};
