import type { Pose } from "@dock-gateway/client";
import { atBeat, BEAT_MS } from "../clock/beat";
import { distance, normalizeAngle, type Point, type View } from "../store/geometry";
import type { GroundPicture } from "../store/layers";
import type { SceneBuffer } from "../store/sceneBuffer";
import type { SceneColors } from "../ui/tokens";
import { type Around, type Seen, UNSEEN } from "./around";
import { type Camera, STILL_PX } from "./camera";
import { Ground, isSameGround } from "./ground";
import { Picture } from "./picture";
import { draw } from "./renderer";
import { footprintOf, pointsOf, shapesOf } from "./shapes";
import { canvasContext } from "./view";

/** What fades does so in steps of this length where motion is not wanted (ms). */
const CALM_MS = 200;

/** A scene as a painter reads it; times are those of `performance.now()`. */
export type SceneSource = Pick<
  SceneBuffer,
  "latest" | "robotAt" | "detectionsAt" | "changesAt" | "subscribe"
> & { trail: Pick<SceneBuffer["trail"], "points"> };

interface Drawn {
  view: View;
  robot: Pose;
  /** The radius of the robot (m). */
  radius: number;
  /** An array that grows while the robot is drawn where it moves, or another one. */
  trail: readonly Point[];
  /** Something of it fades. */
  fading: boolean;
  ground: readonly GroundPicture[];
  /** The scene without the robot. */
  rest: object;
}

function looksTheSame(before: Drawn, after: Drawn): boolean {
  if (before.fading || after.fading || before.view !== after.view || before.trail !== after.trail)
    return false;
  if (!isSameGround(before.ground, after.ground)) return false;
  const turned = Math.abs(normalizeAngle(after.robot.theta - before.robot.theta)) * after.radius;
  const moved = Math.max(distance(before.robot, after.robot), turned) * after.view.scale;
  return moved < STILL_PX && JSON.stringify(before.rest) === JSON.stringify(after.rest);
}

/**
 * Draws the scene on a canvas as its camera sees it: once for every frame in which something changed, and not at all
 * otherwise.
 */
export class Painter extends Picture {
  /** Where the robot is about to be placed. */
  #ghost: Pose | null = null;
  #handle = false;
  #frame: number | undefined;
  #cancelBeat: (() => void) | undefined;
  #drawnAt = 0;
  /** What is on the canvas; null where that is to be redrawn in any case. */
  #drawn: Drawn | null = null;
  readonly #ground = new Ground();
  #seen: Seen = UNSEEN;
  readonly #unsubscribe: () => void;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    camera: Camera,
    private readonly buffer: SceneSource,
    private readonly colors: SceneColors,
    private readonly reducedMotion: boolean,
    private readonly around: Around | null = null,
  ) {
    super(camera);
    this.#unsubscribe = buffer.subscribe(this.#hear);
    if (around !== null) around.onChange = this.#hear;
  }

  get ghost(): Pose | null {
    return this.#ghost;
  }

  /** The robot as it is drawn now. */
  get robot(): Pose | null {
    return this.reducedMotion ? (this.buffer.latest?.robot ?? null) : this.buffer.robotAt(performance.now());
  }

  /** What is around the robot, as it is drawn now. */
  get seen(): Seen {
    return this.#seen;
  }

  /** Shows the whole ground. */
  showGround(): void {
    const { latest } = this.buffer;
    const corners = latest === null ? [] : (this.around?.cornersIn(latest) ?? []);
    if (corners.length > 0) this.camera.frame(corners);
    this.invalidate();
  }

  get radius(): number {
    return footprintOf(this.buffer.latest).radius;
  }

  /** Whether the robot can be dragged. */
  get handle(): boolean {
    return this.#handle;
  }

  set handle(handle: boolean) {
    this.#handle = handle;
    this.invalidate();
  }

  showGhost(ghost: Pose | null): void {
    this.#ghost = ghost;
    this.invalidate();
  }

  /** Keeps the robot in the middle at a scale, by default that of what is seen; no longer for null. */
  follow(scale: number | null = this.view.scale): void {
    this.camera.follow(scale);
    this.invalidate();
  }

  readonly invalidate = (): void => {
    this.#drawn = null;
    this.#look();
  };

  destroy(): void {
    this.#unsubscribe();
    this.around?.destroy();
    this.#rest();
  }

  /** Nothing is to be drawn any more. */
  #rest(): void {
    this.#cancelBeat?.();
    this.#cancelBeat = undefined;
    if (this.#frame !== undefined) cancelAnimationFrame(this.#frame);
    this.#frame = undefined;
  }

  /** Draws in the next frame, if there is something new to see by then. */
  readonly #look = (): void => {
    this.#frame ??= requestAnimationFrame(this.#paint);
  };

  protected points(): Point[] {
    const { latest } = this.buffer;
    if (latest === null) return [];
    const corners = this.around?.shownCornersIn(latest) ?? [];
    return [...pointsOf(latest.robot, shapesOf(latest), footprintOf(latest)), ...corners];
  }

  readonly #paint = (): void => {
    this.#rest();
    if (!this.inSight) return;
    const context = canvasContext(this.canvas, this.size);
    const scene = this.buffer.latest;
    const robot = this.robot;
    if (context === null || scene === null || robot === null) return;
    const now = performance.now();
    // The ground keeps still while a robot is dragged over it.
    if (this.#ghost === null) this.camera.aim(this.points(), robot);
    this.camera.glide(now - this.#drawnAt, this.reducedMotion);
    this.#drawnAt = now;
    const detections = this.buffer.detectionsAt(now);
    const around = this.around?.seenIn(scene, robot, now) ?? UNSEEN;
    this.#seen = around;
    const drawn = {
      view: this.view,
      robot,
      radius: this.radius,
      trail: this.buffer.trail.points,
      fading: detections.length > 0,
      ground: around.ground,
      rest: { ...scene, robot: null, ...around, ground: null },
    };
    if (this.#drawn === null || !looksTheSame(this.#drawn, drawn)) {
      this.#drawn = drawn;
      draw(context, this.#ground, {
        view: this.view,
        size: this.size,
        colors: this.colors,
        frame: scene.frame,
        robot,
        footprint: footprintOf(scene),
        shapes: shapesOf(scene),
        trail: drawn.trail,
        detections,
        infrared: scene.infrared,
        around,
        ghost: this.#ghost,
        handle: this.#handle,
        now,
      });
    }
    if (this.camera.glides) this.#look();
    else if (this.buffer.changesAt(now)) this.#goOn();
  };

  /** A new scene has come: it is drawn as soon as it is its turn. */
  readonly #hear = (): void => {
    if (!this.inSight) return;
    if (this.reducedMotion || performance.now() - this.#drawnAt >= BEAT_MS) this.#look();
    else this.#goOn();
  };

  /** Draws what changes by itself: smoothly, or now and then where motion is not wanted. */
  #goOn(): void {
    this.#cancelBeat ??= atBeat(this.reducedMotion ? CALM_MS : BEAT_MS, this.#paint);
  }
}
