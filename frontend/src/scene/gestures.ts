import type { Pose } from "@dock-gateway/client";
import { distance, normalizeAngle, type Point, type Size, toRadians, type View } from "../store/geometry";
import { HANDLE_RADIUS_PX, handlePlace } from "./renderer";
import { toScreen } from "./view";

/** What is meant to be touched may be missed by this much, in CSS pixels. */
const REACH_PX = 22;
/** A pointer that moves by less is pressed, not moved (CSS pixels). */
const PRESS_PX = 4;
const STEP_M = 0.05;
const TURN_RAD = toRadians(5);
const PAN_PX = 40;
const ZOOM_STEP = 1.3;

/** What gestures move: a picture, and the robot that can be placed where there is one. */
export interface Stage {
  readonly view: View;
  readonly size: Size;
  readonly robot: Pose | null;
  /** The radius of the robot (m). */
  readonly radius: number;
  readonly ghost: Pose | null;
  /** Whether the robot can be dragged. */
  readonly handle: boolean;
  showGhost(ghost: Pose | null): void;
  zoomBy(factor: number, place?: Point): void;
  panBy(dx: number, dy: number): void;
  showAll(): void;
  toWorld(place: Point): Point;
}

type Drag =
  | { kind: "pan"; at: Point }
  | { kind: "move"; grip: Point; theta: number }
  | { kind: "turn"; robot: Pose };

/** What pointer and keyboard do to the picture, and to the robot where it can be placed. */
export class Gestures {
  #drag: Drag | null = null;
  /** Where the pointer went down that has not moved since; null for none. */
  #pressed: Point | null = null;
  readonly #pointers = new Map<number, Point>();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly stage: Stage,
    /** Called where the robot was put somewhere. */
    private readonly onPlace: (pose: Pose) => void = () => {},
    /** Called where the keyboard moves the robot that is about to be placed; null where it was given up. */
    private readonly onGhost: (pose: Pose | null) => void = () => {},
    /** Called where a place was pressed, without moving anything: with Enter, that in the middle. */
    private readonly onPick: ((place: Point) => void) | null = null,
  ) {
    canvas.addEventListener("pointerdown", this.#down);
    canvas.addEventListener("pointermove", this.#move);
    canvas.addEventListener("pointerup", this.#up);
    canvas.addEventListener("pointercancel", this.#cancel);
    canvas.addEventListener("wheel", this.#wheel, { passive: false });
    canvas.addEventListener("touchstart", this.#touch, { passive: false });
    canvas.addEventListener("keydown", this.#key);
  }

  destroy(): void {
    this.canvas.removeEventListener("pointerdown", this.#down);
    this.canvas.removeEventListener("pointermove", this.#move);
    this.canvas.removeEventListener("pointerup", this.#up);
    this.canvas.removeEventListener("pointercancel", this.#cancel);
    this.canvas.removeEventListener("wheel", this.#wheel);
    this.canvas.removeEventListener("touchstart", this.#touch);
    this.canvas.removeEventListener("keydown", this.#key);
  }

  readonly #down = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    const place = this.#place(event);
    this.#pointers.set(event.pointerId, place);
    this.canvas.setPointerCapture(event.pointerId);
    if (this.#pointers.size > 1) {
      this.stage.showGhost(null);
      this.#drag = null;
      this.#pressed = null;
      return;
    }
    this.#pressed = place;
    this.#drag = this.#dragAt(place);
    this.canvas.style.cursor = this.#drag.kind === "pan" ? "move" : "grabbing";
  };

  readonly #move = (event: PointerEvent): void => {
    const place = this.#place(event);
    if (!this.#pointers.has(event.pointerId)) {
      this.canvas.style.cursor = this.#dragAt(place).kind === "pan" ? "" : "grab";
      return;
    }
    if (this.#pressed !== null) {
      if (distance(this.#pressed, place) < PRESS_PX) return;
      this.#pressed = null;
    }
    if (this.#pointers.size > 1) this.#pinch(event.pointerId, place);
    else if (this.#drag !== null) this.#drag = this.#continue(this.#drag, place);
    this.#pointers.set(event.pointerId, place);
  };

  readonly #up = (event: PointerEvent): void => {
    const [drag, pressed] = [this.#drag, this.#pressed];
    this.#forget(event);
    if (pressed !== null && drag?.kind === "pan") this.onPick?.(pressed);
    if (drag === null || drag.kind === "pan" || this.stage.ghost === null) return;
    this.onPlace(this.stage.ghost);
  };

  readonly #cancel = (event: PointerEvent): void => {
    this.#forget(event);
    this.stage.showGhost(null);
  };

  #forget(event: PointerEvent): void {
    this.#pointers.delete(event.pointerId);
    this.#drag = null;
    this.#pressed = null;
    this.canvas.style.cursor = "";
  }

  #dragAt(place: Point): Drag {
    const robot = this.stage.ghost ?? this.stage.robot;
    if (this.stage.handle && robot !== null) {
      const { view, size, radius } = this.stage;
      if (distance(place, handlePlace(view, size, robot, radius)) <= HANDLE_RADIUS_PX + REACH_PX / 2) {
        return { kind: "turn", robot };
      }
      if (distance(place, toScreen(view, size, robot)) <= Math.max(radius * view.scale, REACH_PX)) {
        const point = this.stage.toWorld(place);
        return { kind: "move", grip: { x: robot.x - point.x, y: robot.y - point.y }, theta: robot.theta };
      }
    }
    return { kind: "pan", at: place };
  }

  #continue(drag: Drag, place: Point): Drag {
    if (drag.kind === "pan") {
      this.stage.panBy(place.x - drag.at.x, place.y - drag.at.y);
      return { kind: "pan", at: place };
    }
    const point = this.stage.toWorld(place);
    if (drag.kind === "move") {
      this.stage.showGhost({ x: point.x + drag.grip.x, y: point.y + drag.grip.y, theta: drag.theta });
    } else {
      const theta = Math.atan2(point.y - drag.robot.y, point.x - drag.robot.x);
      this.stage.showGhost({ ...drag.robot, theta });
    }
    return drag;
  }

  #pinch(pointerId: number, place: Point): void {
    const before = this.#pointers.get(pointerId);
    const other = [...this.#pointers].find(([id]) => id !== pointerId)?.[1];
    if (before === undefined || other === undefined) return;
    const factor = distance(place, other) / Math.max(1, distance(before, other));
    this.stage.zoomBy(factor, { x: (place.x + other.x) / 2, y: (place.y + other.y) / 2 });
    this.stage.panBy((place.x - before.x) / 2, (place.y - before.y) / 2);
  }

  /** The wheel alone scrolls the page; with Ctrl, as a pinch on a trackpad sends it, it zooms. */
  readonly #wheel = (event: WheelEvent): void => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    this.stage.zoomBy(Math.exp(-event.deltaY / 300), this.#place(event));
  };

  /** A finger on the robot drags it, a finger anywhere else scrolls the page. */
  readonly #touch = (event: TouchEvent): void => {
    const [touch] = event.touches;
    if (touch === undefined) return;
    if (event.touches.length > 1 || this.#dragAt(this.#place(touch)).kind !== "pan") event.preventDefault();
  };

  readonly #key = (event: KeyboardEvent): void => {
    if (event.altKey || event.metaKey || !this.#handleKey(event)) return;
    event.preventDefault();
  };

  #handleKey({ key, shiftKey, ctrlKey }: KeyboardEvent): boolean {
    const arrow = ARROWS[key];
    if (arrow !== undefined) {
      if (this.stage.handle && !ctrlKey) this.#nudge(arrow, shiftKey);
      else this.stage.panBy(-arrow.x * PAN_PX, arrow.y * PAN_PX);
      return true;
    }
    if (ctrlKey) return false;
    const { ghost } = this.stage;
    if (key === "+" || key === "=") this.stage.zoomBy(ZOOM_STEP);
    else if (key === "-") this.stage.zoomBy(1 / ZOOM_STEP);
    else if (key === "0") this.stage.showAll();
    else if (key === "Enter" && ghost !== null) this.onPlace(ghost);
    else if (key === "Enter" && this.onPick !== null) {
      const { width, height } = this.stage.size;
      this.onPick({ x: width / 2, y: height / 2 });
    } else if (key === "Escape" && ghost !== null) {
      this.stage.showGhost(null);
      this.onGhost(null);
    } else return false;
    return true;
  }

  #nudge(arrow: Point, turning: boolean): void {
    const robot = this.stage.ghost ?? this.stage.robot;
    if (robot === null) return;
    const ghost = turning
      ? { ...robot, theta: normalizeAngle(robot.theta - arrow.x * TURN_RAD) }
      : { ...robot, x: robot.x + arrow.x * STEP_M, y: robot.y + arrow.y * STEP_M };
    this.stage.showGhost(ghost);
    this.onGhost(ghost);
  }

  #place(event: { clientX: number; clientY: number }): Point {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }
}

const ARROWS: Record<string, Point | undefined> = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: 1 },
  ArrowDown: { x: 0, y: -1 },
};
