import type { GatewayEvent, Http, Include, Pose, Scene } from "@dock-gateway/client";
import type { Point, Size, View } from "./geometry";

export type Scheme = "light" | "dark";

/*
 * The order of a picture, from below: grid, ground of layers, numbers of the grid, trail, lines of layers, docks, dots of
 * layers, robots.
 */

/** What an extension draws in the pictures of robots from above, and where its data come from. */
export interface Layers {
  /** What it reads of a robot's stream (`?include=`). */
  robotTopics: readonly Include[];
  /** What it reads of a stream about all robots. */
  fleetTopics: readonly Include[];
  /** Called when the stream of a robot is opened. @param robot Null for the one that the gateway is configured for. */
  ofRobot(http: Http, robot: string | null): RobotLayer;
  /** Called when a stream about all robots is opened. @param httpOf What asks the gateway of a robot. */
  ofFleet(httpOf: (robot: string) => Http): FleetLayer;
}

/** A layer of the picture of one robot. */
export interface SceneLayer {
  /** Calls `listener` when something is to be drawn again, until the returned function is called. */
  subscribe(listener: () => void): () => void;
  /** Where its ground lies in the frame of a scene; null where there is none, or the two are not related. */
  groundIn(scene: Scene): LocatedFrame | null;
  /** Begins to draw. @param onChange Called where something is to be drawn again. */
  paint(scheme: Scheme, onChange: () => void): LayerPainter;
}

/** A layer about one robot, as its stream says. */
export interface RobotLayer extends SceneLayer {
  /** @param now On the clock of the picture (ms). */
  onEvent(event: GatewayEvent, now: number): void;
  /** Where a frame that it knows lies in that of a scene; null for another one, and where the two are not related. */
  frameIn(scene: Scene, frame: string): Pose | null;
  /** What is wrong with it, in sentences. */
  hints(): string[];
  /** What the colors of what is drawn mean. */
  legend(scheme: Scheme): LegendEntry[];
}

export interface LocatedFrame {
  frame: string;
  pose: Pose;
}

export interface LegendEntry {
  name: string;
  /** A CSS color. */
  color: string;
  round?: true;
}

export interface LayerPainter {
  /** What is drawn at a moment, on the clock of the picture (ms). */
  viewIn(scene: Scene, robot: Pose, now: number): LayerView;
  /** What a view of the whole ground has to show; nothing without one. */
  cornersIn(scene: Scene): Point[];
  close(): void;
}

/** What a layer shows, in the frame of a scene. */
export interface LayerView {
  ground: GroundPicture | null;
  lines: readonly Mark[];
  /** Points, such as a laser scan's; those of what a robot waits for stand out. */
  dots: readonly Mark[];
}

/** A picture of the ground: the same object for as long as it looks the same. */
export interface GroundPicture {
  /** The context's unit is the CSS pixel. */
  draw(ctx: CanvasRenderingContext2D, view: View, size: Size): void;
}

export interface Mark {
  points: readonly Point[];
  /** A CSS color. */
  color: string;
}

/** A layer of the picture of all robots. */
export interface FleetLayer {
  /** Takes up an event; whether it changes anything. @param nameOf The name of a robot on this page. */
  onEvent(event: GatewayEvent, nameOf: (robot: string) => string): boolean;
  /** Takes up where the robots are: their scenes by name. Those that it can place are given in the shared frame. */
  arrange(scenes: FleetPoses): FleetPoses;
  /** The frame of its ground; null without one. */
  readonly frame: string | null;
  /** Begins to draw. @param onChange Called where something is to be drawn again. */
  paint(scheme: Scheme, onChange: () => void): FleetLayerPainter;
}

export type FleetPoses = Readonly<Record<string, Scene>>;

/** The frame that robots share, where one of them tells it; else that of a ground. */
export const SHARED_FRAME = "world";

export interface FleetLayerPainter {
  ground(): GroundPicture | null;
  /** What a view of the whole ground has to show; nothing without one. */
  corners(): Point[];
  close(): void;
}

const ORIGIN: Pose = { x: 0, y: 0, theta: 0 };

/** Where a frame lies in that of a scene; null where the two are not related. */
export function frameIn(scene: Scene, layers: readonly RobotLayer[], frame: string): Pose | null {
  if (frame === scene.frame) return ORIGIN;
  if (frame === "odom") return scene.odom ?? null;
  return firstOf(layers, (layer) => layer.frameIn(scene, frame));
}

/** Where the ground of a picture lies in the frame of a scene; null without one. */
export function groundIn(scene: Scene, layers: readonly SceneLayer[]): LocatedFrame | null {
  return firstOf(layers, (layer) => layer.groundIn(scene));
}

function firstOf<Each, Found>(all: readonly Each[], find: (each: Each) => Found | null): Found | null {
  for (const each of all) {
    const found = find(each);
    if (found !== null) return found;
  }
  return null;
}
