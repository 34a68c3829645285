import type { ListedGoal, LiveGoal, Pose } from "@dock-gateway/client";
import type { ComponentType } from "react";
import type { Layers, SceneLayer } from "../store/layers";

/**
 * A feature that can be taken out: what it adds to the dashboard. The rooms below `extensions/` map over the list in
 * extensions.ts and know no extension by its name.
 */
export interface Extension {
  /** That of its folder, and of the gateway's extension that it belongs to, if there is one. */
  name: string;
  pages?: readonly Page[];
  /** What it adds to pages that are not its own, by place. */
  parts?: { [Place in keyof Places]?: ComponentType<Places[Place]> };
  /** Called once, before anything is shown. */
  start?: () => void;
  /** What it draws in pictures of robots from above. */
  layers?: Layers;
}

/** Places a robot elsewhere, which does without driving. */
export interface Placing {
  place: (pose: Pose) => Promise<void>;
  /** Why the login may not; null where it may. */
  forbidden: string | null;
}

/** What the replay of a goal shows besides the robot's stored poses. */
export interface ReplayLayer {
  /** What was around the robot. */
  scene: RecordedLayer;
  /** What else is known of a moment, in words. */
  readings(moment: number | null): string[];
}

/** A layer of a picture of what was; `seek` goes to a moment (s since the goal began), to the end for null. */
export interface RecordedLayer extends SceneLayer {
  seek(moment: number | null): void;
}

/** A page below the header. */
export interface Page {
  /** Where it is: `/ui/statistics`; with `/*` at the end also what is below. */
  path: string;
  Page: ComponentType;
  /** Its entry among the links to all pages. */
  menu?: MenuEntry;
  /** The name of its entry in the menu of the account, which admins have. */
  adminMenu?: string;
  /** Where it is: only on pages about one gateway's robots, only on those about several sites; everywhere without it. */
  at?: "gateway" | "sites";
}

interface MenuEntry {
  name: string;
  /** The letter that opens the page when it is pressed after g. */
  letter: string;
  /** Entries are sorted by it. */
  order: number;
  /** Reached by a button of the header where there is room for the links to the others. */
  button?: true;
}

/** Starts extensions, each by itself: one that fails keeps no other from it. */
export function startAll(extensions: readonly Extension[]): void {
  for (const { start } of extensions) {
    try {
      start?.();
    } catch (error) {
      reportError(error);
    }
  }
}

/** The pages of extensions. */
export function pagesOf(extensions: readonly Extension[]): Page[] {
  return extensions.flatMap(({ pages = [] }) => pages);
}

/** What extensions draw in pictures of robots, the lowest first. */
export function layersOf(extensions: readonly Extension[]): Layers[] {
  return extensions.flatMap(({ layers }) => layers ?? []);
}

/** What extensions add at a place, by their names. */
export function partsAt<Place extends keyof Places>(
  extensions: readonly Extension[],
  place: Place,
): [string, ComponentType<Places[Place]>][] {
  return extensions.flatMap(({ name, parts }) => {
    const Part = parts?.[place];
    return Part === undefined ? [] : [[name, Part as ComponentType<Places[Place]>]];
  });
}

/** The places for parts of extensions, and what a part there is given. */
export interface Places {
  /** On every page, below the stops that hold: those that need somebody. */
  stops: object;
  /** Below the list of users. */
  users: object;
  /** Above the fields of a login. */
  login: object;
  /** First among the panels for developers of a robot. */
  developer: object;
  /** Below what has to be done about a robot: the column beside its map. */
  robotColumn: OfRobot;
  /** Beside a robot's name. */
  robotHead: OfRobot;
  /** Below the plots of a robot's battery. */
  robotPanels: OfRobot;
  /** Beside the verdict on a goal. */
  goalHead: OfGoal;
  /** Among what can be done about a goal. */
  goalCommands: OfGoal;
  /** Below the motion of a goal, above its feedback. */
  goalPanels: OfGoal;
  /** Beside the origin of a goal: what sent it. */
  goalOrigin: OfGoal;
  /** Beside the name of a goal in a list. */
  listedGoal: { goal: GoalInList };
  /** Beside a link to a goal that has ended. */
  linkedGoal: { goalId: string };
  /** Shows nothing itself: calls `onLayer` with what it adds to the replay of a goal that has ended, null for nothing. */
  replay: OfGoal & { onLayer: (layer: ReplayLayer | null) => void };
  /** Shows nothing itself: calls `onPlacing` with how the page's robot is placed by dragging it, null where it is not. */
  placing: { onPlacing: (placing: Placing | null) => void };
  /** On the page about notifications of alerts. */
  notifications: object;
}

export type GoalInList = Omit<
  ListedGoal,
  "goal" | "feedback" | "result" | "feedback_count" | "last_event_id"
>;

interface OfGoal {
  goal: LiveGoal;
}

interface OfRobot {
  /** Its name, that of the configured robot included. */
  robot: string;
}
