import type { Footprint, GatewayEvent, Pose, RobotMap, Scene, StreamHandlers } from "@dock-gateway/client";
import type { MapColors } from "../../api/client";
import type { Camera } from "../../scene/camera";
import type { SceneColors } from "../../scene/colors";
import type { Stage } from "../../scene/gestures";
import { drawGrid } from "../../scene/ground";
import { cornersOf, type DrawnMap, MapImage } from "../../scene/mapImage";
import { Picture } from "../../scene/picture";
import { drawDock, drawScaleBar } from "../../scene/renderer";
import { around, arrowRadius, footprintOf } from "../../scene/shapes";
import { canvasContext, toScreen } from "../../scene/view";
import { compose, type Point } from "../../store/geometry";
import { frameIn } from "../../store/surroundings";

/** The frame that robots share, where one of them tells it; else that of their map. */
const FRAME = "world";
const ORIGIN: Pose = { x: 0, y: 0, theta: 0 };

/** A robot can be seen and pressed from far away, too (px). */
const LEAST_PX = 24;
/** Names have room beside their robots (px). */
export const INSET_PX = 36;

/** What a map is drawn with. */
interface MapMeans {
  colors: MapColors;
  load: (robot: string, colors: MapColors) => Promise<Blob>;
}

/** Draws the ground and the docks on a canvas, and puts the robots, which are elements above it, in their places. */
export class FleetStage extends Picture implements Stage {
  readonly robot = null;
  readonly radius = 0;
  readonly ghost = null;
  readonly handle = false;
  readonly #unsubscribe: () => void;
  readonly #image: MapImage;
  #frame: number | undefined;
  #drawnAt = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    camera: Camera,
    /** By name; as they are on the page. */
    private readonly robots: ReadonlyMap<string, HTMLElement>,
    private readonly scenes: FleetScenes,
    private readonly colors: SceneColors,
    private readonly reducedMotion: boolean,
    map: MapMeans,
  ) {
    super(camera);
    this.#image = new MapImage(
      map.colors,
      (colors) => map.load(scenes.ground?.robot ?? "/", colors),
      () => this.invalidate(),
    );
    this.#unsubscribe = scenes.subscribe(this.invalidate);
    this.invalidate();
  }

  showGhost(): void {}

  readonly invalidate = (): void => {
    this.#frame ??= requestAnimationFrame(this.#paint);
  };

  destroy(): void {
    this.#unsubscribe();
    this.#image.close();
    if (this.#frame !== undefined) cancelAnimationFrame(this.#frame);
  }

  #shared() {
    return Object.entries(this.scenes.latest).filter(([, { frame }]) => frame === FRAME);
  }

  #map(): DrawnMap | null {
    const { ground } = this.scenes;
    this.#image.show(ground?.map.map ?? null);
    return this.#image.placeAt(ground?.at ?? null);
  }

  /** Shows the whole map. */
  showMap(): void {
    const { ground } = this.scenes;
    const corners = cornersOf(ground?.map.map ?? null, ground?.at ?? null);
    if (corners.length > 0) this.camera.frame(corners);
    this.invalidate();
  }

  protected points(): Point[] {
    return this.#shared().flatMap(([, scene]) => {
      const corners = around(scene.robot, footprintOf(scene));
      return scene.dock === null ? corners : [...corners, scene.dock];
    });
  }

  readonly #paint = (now: number): void => {
    this.#frame = undefined;
    const context = canvasContext(this.canvas, this.size);
    if (!this.inSight || context === null) return;
    this.camera.aim(this.points(), null);
    this.camera.glide(now - this.#drawnAt, this.reducedMotion);
    this.#drawnAt = now;
    const picture = { view: this.view, size: this.size, colors: this.colors, frame: this.scenes.frame };
    context.clearRect(0, 0, this.size.width, this.size.height);
    drawGrid(context, picture, this.#map());
    const shared = this.#shared();
    const docks = new Map(shared.flatMap(([, { dock }]) => (dock ? [[JSON.stringify(dock), dock]] : [])));
    for (const dock of docks.values()) drawDock(context, picture, dock);
    drawScaleBar(context, picture);
    for (const [name, scene] of shared) this.#place(name, scene);
    if (this.camera.glides) this.invalidate();
  };

  #place(name: string, scene: Scene): void {
    const element = this.robots.get(name);
    if (element === undefined) return;
    const { robot } = scene;
    const footprint = footprintOf(scene);
    const { x, y } = toScreen(this.view, this.size, robot);
    const size = Math.max(LEAST_PX, 2 * footprint.radius * this.view.scale);
    element.style.setProperty("--size", `${size.toFixed(1)}px`);
    element.style.setProperty("--outline", outlineOf(footprint));
    element.style.setProperty("--arrow", (arrowRadius(footprint) / footprint.radius).toFixed(3));
    element.style.setProperty("--turn", `${(-robot.theta).toFixed(3)}rad`);
    element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    element.dataset.placed = "";
  }
}

/** The circle around a footprint is a little smaller than the element that shows it (%). */
const RADIUS = 47;

/** A footprint as a CSS shape: of a square element with base_link in its middle, x to the right. */
function outlineOf({ radius, points }: Footprint): string {
  if (points === null) return `circle(${RADIUS}%)`;
  const place = (metres: number) => `${(50 + (RADIUS * metres) / radius).toFixed(1)}%`;
  return `polygon(${points.map(({ x, y }) => `${place(x)} ${place(-y)}`).join(", ")})`;
}

/** By robot, the frame that its pose is given in. */
export type Frames = ReadonlyMap<string, Scene["frame"]>;

/** The map below all robots. */
interface GroundMap {
  /** One whose map it is. */
  robot: string;
  map: RobotMap;
  /** Where its frame lies in the one that robots share. */
  at: Pose;
}

/**
 * The scenes of all robots as they come. A robot without a frame that it shares is placed by its map, if that is the map
 * of the others: its scene is then as if it were in their frame.
 */
export class FleetScenes implements StreamHandlers {
  latest: Readonly<Record<string, Scene>> = {};
  ground: GroundMap | null = null;
  /** When the latest came (ms, on the clock of `performance.now()`). */
  arrivedAt = Number.NEGATIVE_INFINITY;
  /** The same map until a robot appears, disappears or changes its frame; null before the first event. */
  frames: Frames | null = null;
  #told: Readonly<Record<string, Scene>> = {};
  #maps: Readonly<Record<string, RobotMap>> = {};
  readonly #listeners = new Set<() => void>();

  /** The name of the frame that is drawn. */
  get frame(): string {
    const shared = Object.values(this.#told).some(({ frame }) => frame === FRAME);
    return shared || this.ground === null ? FRAME : (this.ground.map.map?.frame ?? "map");
  }

  readonly onEvent = (event: GatewayEvent): void => {
    if (event.type === "maps") this.#maps = event.maps;
    else if (event.type === "scenes") {
      this.#told = event.scenes;
      this.arrivedAt = performance.now();
    } else return;
    this.ground = this.#findGround();
    this.latest = Object.fromEntries(
      Object.entries(this.#told).map(([robot, scene]) => [robot, this.#share(robot, scene)]),
    );
    if (event.type === "maps" && this.frames === null) return;
    const frames = new Map(Object.entries(this.latest).map(([robot, { frame }]) => [robot, frame]));
    if (this.frames === null || !isSame(this.frames, frames)) this.frames = frames;
    for (const listener of this.#listeners) listener();
  };

  #findGround(): GroundMap | null {
    const known = Object.entries(this.#told).flatMap(([robot, scene]) => {
      const map = this.#maps[robot];
      return map?.map == null ? [] : [{ robot, scene, map }];
    });
    for (const { robot, scene, map } of known) {
      const at = scene.frame === FRAME ? frameIn(scene, map, "map") : null;
      if (at !== null) return { robot, map, at };
    }
    if (Object.values(this.#told).some(({ frame }) => frame === FRAME)) return null;
    const first = known.find(({ map }) => map.odom !== null);
    return first === undefined ? null : { robot: first.robot, map: first.map, at: ORIGIN };
  }

  #share(robot: string, scene: Scene): Scene {
    const map = this.#maps[robot];
    const { ground } = this;
    if (scene.frame === FRAME || map?.odom == null || ground === null) return scene;
    if (map.topic !== ground.map.topic) return scene;
    return { ...scene, frame: FRAME, robot: compose(ground.at, compose(map.odom, scene.robot)) };
  }

  /** The connection is that of all pages. */
  readonly onConnection = (): void => {};

  /** Calls `listener` for every event, until the returned function is called. */
  readonly subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };
}

function isSame(one: Frames, other: Frames): boolean {
  return one.size === other.size && [...one].every(([robot, frame]) => other.get(robot) === frame);
}
