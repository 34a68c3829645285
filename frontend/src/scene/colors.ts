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
