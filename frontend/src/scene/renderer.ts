import type { Footprint, Infrared, Pose } from "@dock-gateway/client";
import { compose, type Point, type Size, type View } from "../store/geometry";
import { type Detection, FADE_MS } from "../store/sceneBuffer";
import { type Seen, sameDock } from "./around";
import { type Drawing, type Ground, write } from "./ground";
import { Labels } from "./labels";
import { drawDots, drawLine } from "./marks";
import {
  arrowRadius,
  CONTACT_RADIUS_M,
  DOCK_BOX,
  RECEIVER_FIELD_RAD,
  RECEIVER_X_M,
  RECEIVERS,
  type Shapes,
  UNSEEN_BEAM_M,
} from "./shapes";
import { formatLength, gridStep, toScreen } from "./view";

/** All that one picture is made of. */
interface Picture extends Drawing {
  /** In which all poses are. */
  frame: string;
  robot: Pose;
  footprint: Footprint;
  shapes: Shapes;
  trail: readonly Point[];
  detections: readonly Detection[];
  infrared: Infrared | null;
  around: Seen;
  /** Where the robot is about to be placed. */
  ghost: Pose | null;
  /** Whether the robot can be dragged, so that a handle to turn it by is shown. */
  handle: boolean;
  /** On the clock of the detections (ms). */
  now: number;
}

/** The handle that turns the robot is so far before its centre, in CSS pixels beyond its edge. */
const HANDLE_PX = 22;
export const HANDLE_RADIUS_PX = 7;

/** Where the handle of a robot is on the canvas. @param radius Of the robot (m). */
export function handlePlace(view: View, size: Size, robot: Pose, radius: number): Point {
  const centre = toScreen(view, size, robot);
  const reach = radius * view.scale + HANDLE_PX;
  return { x: centre.x + reach * Math.cos(robot.theta), y: centre.y - reach * Math.sin(robot.theta) };
}

/** Draws one picture on its ground. The context's unit is the CSS pixel. */
export function draw(ctx: CanvasRenderingContext2D, ground: Ground, picture: Picture): void {
  const { shapes, robot, ghost, around } = picture;
  ground.draw(ctx, { ...picture, pictures: around.ground });
  for (const line of around.lines) drawLine(ctx, picture, line);
  if (shapes.staging !== null) drawStaging(ctx, picture, shapes.staging);
  if (shapes.docked !== null) drawContactZone(ctx, picture, shapes.docked);
  for (const dock of docksOf(picture)) drawDock(ctx, picture, dock.pose);
  for (const dots of around.dots) drawDots(ctx, picture, robot, dots, around.blocked);
  drawBeams(ctx, picture, robot);
  drawRobot(ctx, picture, robot, ghost === null ? 1 : 0.35);
  drawDetections(ctx, picture);
  if (ghost !== null) drawRobot(ctx, picture, ghost, 0.8);
  if (picture.handle) drawHandle(ctx, picture, ghost ?? robot);
  drawLabels(ctx, picture);
  drawScaleBar(ctx, picture);
}

/** The docks, that of the robot first, which has a name only if it is one of the others. */
function docksOf({ shapes, around }: Picture): { pose: Pose; name?: string }[] {
  if (shapes.dock === null) return [...around.docks];
  const own = sameDock(shapes.dock, around.docks);
  const first = own === undefined ? { pose: shapes.dock } : { ...own, pose: shapes.dock };
  return [first, ...around.docks.filter((dock) => dock !== own)];
}

/** Where a robot is to stand, dashed; what follows is drawn in the same colour and width. */
function drawPlace(
  ctx: CanvasRenderingContext2D,
  picture: Picture,
  pose: Pose,
  color: string,
  dashes: readonly number[],
): void {
  ctx.strokeStyle = color;
  ctx.lineWidth = 1.5;
  ctx.setLineDash([...dashes]);
  body(ctx, picture, pose);
  ctx.stroke();
  ctx.setLineDash([]);
}

function drawStaging(ctx: CanvasRenderingContext2D, picture: Picture, staging: Pose): void {
  const { colors, footprint } = picture;
  ctx.save();
  drawPlace(ctx, picture, staging, colors.staging, [5, 4]);
  const tip = arrowRadius(footprint) * 0.75;
  path(ctx, picture, staging, [
    [-tip * 0.4, tip * 0.5],
    [tip * 0.6, 0],
    [-tip * 0.4, -tip * 0.5],
  ]);
  ctx.stroke();
  ctx.restore();
}

function drawContactZone(ctx: CanvasRenderingContext2D, picture: Picture, docked: Pose): void {
  const { view, size, colors } = picture;
  ctx.save();
  drawPlace(ctx, picture, docked, colors.contact, [3, 3]);
  const centre = toScreen(view, size, docked);
  ctx.beginPath();
  ctx.arc(centre.x, centre.y, Math.max(3, CONTACT_RADIUS_M * view.scale), 0, 2 * Math.PI);
  ctx.fillStyle = colors.contact;
  ctx.globalAlpha = 0.55;
  ctx.fill();
  ctx.restore();
}

export function drawDock(ctx: CanvasRenderingContext2D, picture: Drawing, dock: Pose): void {
  const { colors, view } = picture;
  const { front, back, half } = DOCK_BOX;
  box(ctx, picture, dock, front, back, half);
  ctx.fillStyle = colors.dock;
  ctx.fill();
  ctx.strokeStyle = colors.dockEdge;
  ctx.lineWidth = 1.5;
  ctx.stroke();
  for (const side of [0.05, -0.05]) {
    box(ctx, picture, compose(dock, { x: 0, y: side, theta: 0 }), front - 0.01, front + 0.02, 0.018);
    ctx.fillStyle = colors.contact;
    ctx.fill();
  }
  // The marker, on edge as it is from above.
  path(ctx, picture, dock, [
    [0, -0.08],
    [0, 0.08],
  ]);
  ctx.strokeStyle = colors.marker;
  ctx.lineWidth = Math.max(2, 0.015 * view.scale);
  ctx.stroke();
}

function drawBeams(ctx: CanvasRenderingContext2D, picture: Picture, robot: Pose): void {
  const { view, size, colors, infrared } = picture;
  if (infrared === null) return;
  ctx.save();
  ctx.fillStyle = colors.beam;
  ctx.strokeStyle = colors.beam;
  ctx.lineWidth = 1;
  for (const name of ["left", "center", "right"] as const) {
    const eye = compose(robot, { x: RECEIVER_X_M, y: 0, theta: RECEIVERS[name] });
    const seen = infrared[name];
    const from = toScreen(view, size, eye);
    const half = RECEIVER_FIELD_RAD / 2;
    ctx.beginPath();
    ctx.moveTo(from.x, from.y);
    ctx.arc(from.x, from.y, (seen ?? UNSEEN_BEAM_M) * view.scale, -eye.theta - half, -eye.theta + half);
    ctx.closePath();
    ctx.setLineDash(seen === null ? [2, 4] : []);
    ctx.globalAlpha = 0.16;
    if (seen !== null) ctx.fill();
    ctx.globalAlpha = seen === null ? 0.3 : 0.75;
    ctx.stroke();
  }
  ctx.restore();
}

function drawRobot(ctx: CanvasRenderingContext2D, picture: Picture, robot: Pose, alpha: number): void {
  const { colors } = picture;
  ctx.save();
  ctx.globalAlpha = alpha;
  body(ctx, picture, robot);
  ctx.fillStyle = colors.robot;
  ctx.fill();
  ctx.strokeStyle = colors.robotEdge;
  ctx.lineWidth = 2;
  ctx.stroke();
  const radius = arrowRadius(picture.footprint);
  path(ctx, picture, robot, [
    [radius * 0.72, 0],
    [-radius * 0.42, radius * 0.5],
    [-radius * 0.16, 0],
    [-radius * 0.42, -radius * 0.5],
  ]);
  ctx.closePath();
  ctx.fillStyle = colors.onRobot;
  ctx.fill();
  ctx.restore();
}

function drawDetections(ctx: CanvasRenderingContext2D, picture: Picture): void {
  const { view, size, colors, detections, now } = picture;
  ctx.save();
  ctx.strokeStyle = colors.marker;
  ctx.fillStyle = colors.marker;
  for (const { pose, at } of detections) {
    const age = (now - at) / FADE_MS;
    const place = toScreen(view, size, pose);
    // Where the marker looks, which is out of the dock.
    const tip = toScreen(view, size, compose(pose, { x: -0.07, y: 0, theta: 0 }));
    ctx.globalAlpha = Math.max(0, 1 - age) * 0.8;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(place.x, place.y);
    ctx.lineTo(tip.x, tip.y);
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(place.x, place.y, 3, 0, 2 * Math.PI);
    ctx.fill();
  }
  ctx.restore();
}

function drawHandle(ctx: CanvasRenderingContext2D, picture: Picture, robot: Pose): void {
  const { view, size, colors, footprint } = picture;
  const place = handlePlace(view, size, robot, footprint.radius);
  const edge = toScreen(view, size, compose(robot, { x: arrowRadius(footprint), y: 0, theta: 0 }));
  ctx.beginPath();
  ctx.moveTo(edge.x, edge.y);
  ctx.lineTo(place.x, place.y);
  ctx.strokeStyle = colors.ghost;
  ctx.lineWidth = 1.5;
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(place.x, place.y, HANDLE_RADIUS_PX, 0, 2 * Math.PI);
  ctx.fillStyle = colors.onRobot;
  ctx.fill();
  ctx.lineWidth = 2.5;
  ctx.stroke();
}

/** How long a length is on the picture; and the frame. */
export function drawScaleBar(
  ctx: CanvasRenderingContext2D,
  { view, size, colors, frame }: Drawing & Pick<Picture, "frame">,
): void {
  const metres = gridStep(view.scale, 60);
  const length = metres * view.scale;
  const [x, y] = [14, size.height - 14];
  ctx.beginPath();
  ctx.moveTo(x, y - 5);
  ctx.lineTo(x, y);
  ctx.lineTo(x + length, y);
  ctx.lineTo(x + length, y - 5);
  ctx.strokeStyle = colors.text;
  ctx.lineWidth = 1.5;
  ctx.stroke();
  ctx.font = FONT;
  ctx.textAlign = "left";
  ctx.textBaseline = "bottom";
  write(ctx, { colors }, formatLength(metres), x, y - 7, colors.text);
  write(ctx, { colors }, `frame ${frame}`, x + length + 12, y + 2, colors.text);
}

/** Farther away (CSS pixels a metre), only what has a name of its own is labelled. */
const LABELLED = 60;
const FONT_PX = 12;
const FONT = `${FONT_PX}px system-ui, sans-serif`;
/** A label is so far below what it names (CSS pixels). */
const BELOW_PX = 6;

/** The names of the docks, and where the robot gets ready; one that would lie on another one is left out. */
function drawLabels(ctx: CanvasRenderingContext2D, picture: Picture): void {
  const { shapes, colors, view, size, footprint } = picture;
  const near = view.scale >= LABELLED;
  const labels = new Labels();
  ctx.font = FONT;
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  const label = (below: Point, text: string, color: string) => {
    const { x, y } = toScreen(view, size, below);
    const room = { width: ctx.measureText(text).width, height: FONT_PX };
    if (labels.take({ x, y: y + BELOW_PX }, room)) write(ctx, picture, text, x, y + BELOW_PX, color);
  };
  const { front, back, half } = DOCK_BOX;
  for (const { pose, name } of docksOf(picture))
    if (near || name !== undefined)
      label(compose(pose, { x: (front + back) / 2, y: -half, theta: 0 }), name ?? "dock", colors.text);
  const { staging } = shapes;
  if (near && staging !== null)
    label({ x: staging.x, y: staging.y - footprint.radius }, "staging pose", colors.staging);
}

/** The outline of the robot at a pose. */
function body(ctx: CanvasRenderingContext2D, picture: Picture, pose: Pose): void {
  const { view, size, footprint } = picture;
  if (footprint.points !== null) {
    path(
      ctx,
      picture,
      pose,
      footprint.points.map(({ x, y }) => [x, y] as const),
    );
    ctx.closePath();
    return;
  }
  const { x, y } = toScreen(view, size, pose);
  ctx.beginPath();
  ctx.arc(x, y, footprint.radius * view.scale, 0, 2 * Math.PI);
}

/** A line through points that are given in the frame of `pose`. */
function path(
  ctx: CanvasRenderingContext2D,
  { view, size }: Drawing,
  pose: Pose,
  points: readonly (readonly [number, number])[],
): void {
  ctx.beginPath();
  for (const [x, y] of points) {
    const place = toScreen(view, size, compose(pose, { x, y, theta: 0 }));
    ctx.lineTo(place.x, place.y);
  }
}

function box(
  ctx: CanvasRenderingContext2D,
  picture: Drawing,
  pose: Pose,
  front: number,
  back: number,
  half: number,
): void {
  path(ctx, picture, pose, [
    [front, half],
    [back, half],
    [back, -half],
    [front, -half],
  ]);
  ctx.closePath();
}
