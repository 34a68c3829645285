import type { Footprint, Scene } from "@dock-gateway/client";
import type { Camera } from "../../scene/camera";
import type { Stage } from "../../scene/gestures";
import { drawGrid } from "../../scene/ground";
import { Labels } from "../../scene/labels";
import { type Means, Picture } from "../../scene/picture";
import { drawDock, drawScaleBar } from "../../scene/renderer";
import { around, arrowRadius, footprintOf } from "../../scene/shapes";
import { canvasContext, toScreen } from "../../scene/view";
import type { Point } from "../../store/geometry";
import { type FleetLayerPainter, SHARED_FRAME } from "../../store/layers";
import type { FleetScenes } from "./scenes";

/** A robot can be seen and pressed from far away, too (px). */
const LEAST_PX = 24;
/** Names have room beside their robots (px). */
export const INSET_PX = 36;

/** Draws the ground and the docks on a canvas, and puts the robots, which are elements above it, in their places. */
export class FleetStage extends Picture implements Stage {
  readonly robot = null;
  readonly radius = 0;
  readonly ghost = null;
  readonly handle = false;
  readonly #unsubscribe: () => void;
  readonly #painters: readonly FleetLayerPainter[];
  #frame: number | undefined;
  #drawnAt = 0;

  constructor(
    private readonly means: Means,
    camera: Camera,
    /** The elements of the robots on the page, by name. */
    private readonly robots: ReadonlyMap<string, HTMLElement>,
    private readonly scenes: FleetScenes,
  ) {
    super(camera);
    this.#painters = scenes.layers.map((layer) => layer.paint(means.scheme, this.invalidate));
    this.#unsubscribe = scenes.subscribe(this.invalidate);
    this.invalidate();
  }

  showGhost(): void {}

  readonly invalidate = (): void => {
    this.#frame ??= requestAnimationFrame(this.#paint);
  };

  destroy(): void {
    this.#unsubscribe();
    for (const painter of this.#painters) painter.close();
    if (this.#frame !== undefined) cancelAnimationFrame(this.#frame);
  }

  #shared() {
    return Object.entries(this.scenes.latest).filter(([, { frame }]) => frame === SHARED_FRAME);
  }

  /** Shows the whole ground. */
  showGround(): void {
    const corners = this.#painters.flatMap((painter) => painter.corners());
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
    const { canvas, colors, reducedMotion } = this.means;
    const context = canvasContext(canvas, this.size);
    if (!this.inSight || context === null) return;
    this.camera.aim(this.points(), null);
    this.camera.glide(now - this.#drawnAt, reducedMotion);
    this.#drawnAt = now;
    const picture = { view: this.view, size: this.size, colors, frame: this.scenes.frame };
    context.clearRect(0, 0, this.size.width, this.size.height);
    drawGrid(
      context,
      picture,
      this.#painters.flatMap((painter) => painter.ground() ?? []),
    );
    const shared = this.#shared();
    const docks = new Map(shared.flatMap(([, { dock }]) => (dock ? [[JSON.stringify(dock), dock]] : [])));
    for (const dock of docks.values()) drawDock(context, picture, dock);
    drawScaleBar(context, picture);
    for (const [name, scene] of shared) this.#place(name, scene);
    this.#label(shared);
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

  /** Names robots as far as there is room, those that are in trouble first. */
  #label(scenes: readonly (readonly [string, Scene])[]): void {
    const labels = new Labels();
    const found = scenes.flatMap(([name, { robot }]) => {
      const element = this.robots.get(name);
      const label = element?.querySelector<HTMLElement>("[data-label]");
      if (!element || !label) return [];
      const { x, y } = toScreen(this.view, this.size, robot);
      const { offsetWidth: width, offsetHeight: height, offsetTop } = label;
      const urgency = LEVELS.indexOf(element.dataset.level);
      return {
        element,
        urgency,
        top: { x, y: y + offsetTop - element.offsetHeight / 2 },
        size: { width, height },
      };
    });
    for (const { element, top, size } of found.sort((one, other) => other.urgency - one.urgency))
      element.toggleAttribute("data-crowded", !labels.take(top, size));
  }
}

/** What the page says of robots, from good to bad. */
const LEVELS: readonly (string | undefined)[] = [undefined, "warning", "critical"];

/** The circle around a footprint is a little smaller than the element that shows it (%). */
const RADIUS = 47;

/** A footprint as a CSS shape: of a square element with base_link in its middle, x to the right. */
function outlineOf({ radius, points }: Footprint): string {
  if (points === null) return `circle(${RADIUS}%)`;
  const place = (metres: number) => `${(50 + (RADIUS * metres) / radius).toFixed(1)}%`;
  return `polygon(${points.map(({ x, y }) => `${place(x)} ${place(-y)}`).join(", ")})`;
}
