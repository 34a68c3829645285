import type { Robot } from "@dock-gateway/client";
import { placeOf } from "../api/places";

/** What a robot is called, and the groups that it is in. */
export type Label = Pick<Robot, "name" | "display_name" | "groups">;

/** A namespace for people: the root namespace is a slash, which names nothing. */
export function namespaceWords(namespace: string): string {
  return namespace === "/" ? "Robot" : namespace;
}

/** The display name, else the namespace. */
export function robotName({ name, display_name }: Omit<Label, "groups">): string {
  return display_name ?? namespaceWords(name);
}

/** The names of all robots, for wherever one is named. */
export class Naming {
  readonly #labels: ReadonlyMap<string, Label>;

  constructor(labels: Iterable<Label>) {
    this.#labels = new Map([...labels].map((label) => [label.name, label]));
  }

  /** These names, unless one of the robots has another name or other groups. */
  updated(robots: ReadonlyMap<string, Label>): Naming {
    const same =
      robots.size === this.#labels.size &&
      [...robots.values()].every((robot) => isSame(robot, this.#labels.get(robot.name)));
    return same ? this : new Naming(robots.values());
  }

  /** Null where it has none. */
  displayNameOf(robot: string): string | null {
    return this.#labels.get(robot)?.display_name ?? null;
  }

  /** The display name, else the namespace. */
  nameOf(robot: string): string {
    return robotName({ name: robot, display_name: this.displayNameOf(robot) });
  }

  /** The namespace of a robot that has a display name; null where the name says it. */
  besides(robot: string): string | null {
    return this.nameOf(robot) === namespaceWords(robot) ? null : robot;
  }

  /** `Left forklift (/robot1)` */
  fullNameOf(robot: string): string {
    const namespace = this.besides(robot);
    return namespace === null ? this.nameOf(robot) : `${this.nameOf(robot)} (${namespace})`;
  }

  /** `/robot1, /robot2 and 7 more`: no more than `most` names, and never "1 more". */
  list(robots: readonly string[], most = 6): string {
    const names = robots.map((robot) => this.nameOf(robot));
    if (names.length <= most) return names.join(", ");
    return `${names.slice(0, most - 1).join(", ")} and ${names.length - most + 1} more`;
  }

  /** The robot of an action: the one with the longest namespace that contains it; null where none is known. */
  ownerOf(action: string): string | null {
    let namespace = action;
    do {
      namespace = namespace.slice(0, namespace.lastIndexOf("/")) || "/";
      if (this.#labels.has(namespace)) return namespace;
    } while (namespace !== "/");
    return null;
  }

  /** The display name of the robot whose action this is; null where it has none. */
  ownerNameOf(action: string): string | null {
    const owner = this.ownerOf(action);
    // An action below a namespace is not that of the robot in the root namespace.
    const below = owner === "/" && action.lastIndexOf("/") > 0;
    return owner === null || below ? null : this.displayNameOf(owner);
  }

  /** Who carries out an action: its robot, else the namespace that it is in; null for one of a robot that is not known. */
  actorOf(action: string): string | null {
    const owner = this.ownerOf(action);
    const namespace = action.slice(0, action.lastIndexOf("/"));
    if (owner !== null && (owner !== "/" || namespace === "")) return this.nameOf(owner);
    return namespace === "" ? null : namespace;
  }

  groupsOf(robot: string): readonly string[] {
    return this.#labels.get(robot)?.groups ?? [];
  }

  /** The robots that are in a group. */
  robotsIn(group: string): string[] {
    return [...this.#labels.values()].filter(({ groups }) => groups.includes(group)).map(({ name }) => name);
  }

  /** Whether an action's robot is in a group. */
  isActionOf(action: string, group: string): boolean {
    const owner = this.ownerOf(action);
    return owner !== null && this.groupsOf(owner).includes(group);
  }

  /** Compares two robots by their namespaces: the order in which every page lists robots. */
  compare(a: string, b: string): number {
    const named = (name: string) => ({ name, display_name: this.displayNameOf(name) });
    return inOrder(named(a), named(b));
  }

  /** Robots by their namespaces, each once, in the order of every page. */
  inOrder(robots: Iterable<string>): string[] {
    return [...new Set(robots)].sort((a, b) => this.compare(a, b));
  }

  /** The groups of all robots, in alphabetical order. */
  groups(): string[] {
    const all = [...this.#labels.values()].flatMap(({ groups }) => groups);
    return [...new Set(all)].sort((a, b) => a.localeCompare(b));
  }
}

function isSame(one: Label, other: Label | undefined): boolean {
  if (one === other) return true;
  // A group is one line of text.
  return one.display_name === other?.display_name && one.groups.join("\n") === other.groups.join("\n");
}

/** Whether a text is a part of a robot's name, of its namespace or of one of its groups, whatever their case. */
export function isFound({ name, display_name, groups }: Label, text: string): boolean {
  const wanted = text.trim().toLowerCase();
  return [namespaceWords(name), name, display_name ?? "", ...groups].some((each) =>
    each.toLowerCase().includes(wanted),
  );
}

/** The name of the robot that the gateway is configured for. */
export function defaultRobot(robots: ReadonlyMap<string, Robot>): string {
  for (const robot of robots.values()) if (robot.default) return robot.name;
  return "/";
}

/** Whether a namespace is another one, or in it. */
export function isUnder(name: string, namespace: string): boolean {
  return name === namespace || isBelow(name, namespace);
}

/** Whether a name is in a namespace. */
export function isBelow(name: string, namespace: string): boolean {
  return name.startsWith(namespace === "/" ? "/" : `${namespace}/`);
}

const collator = new Intl.Collator(undefined, { numeric: true });

/** `/robot2` before `/robot10`. */
export function byName(a: string, b: string): number {
  return collator.compare(a, b);
}

/** The order in which every page lists robots: by site, then by the name that is shown, `/robot2` before `/robot10`. */
export function inOrder(a: Omit<Label, "groups">, b: Omit<Label, "groups">): number {
  return (
    byName(placeOf(a.name).site ?? "", placeOf(b.name).site ?? "") ||
    byName(robotName(a), robotName(b)) ||
    byName(a.name, b.name)
  );
}

/** The tabs of a robot's page, as its address names them. */
export const OPERATE = "operate";
export const DEVELOPER = "developer";

export type Tab = typeof OPERATE | typeof DEVELOPER;

export function readTab(query: URLSearchParams): Tab {
  return query.get("tab") === DEVELOPER ? DEVELOPER : OPERATE;
}

/** The query with another tab; the first one is left out. */
export function withTab(query: URLSearchParams, tab: Tab): URLSearchParams {
  const changed = new URLSearchParams(query);
  if (tab === OPERATE) changed.delete("tab");
  else changed.set("tab", tab);
  return changed;
}

/** Where a robot's page is; on a page about several sites that of its site. */
export function robotPath(robot: string, tab: Tab = OPERATE): string {
  const { prefix, name } = placeOf(robot);
  const path = `${prefix}/ui/robot?robot=${encodeURIComponent(name).replaceAll("%2F", "/")}`;
  return tab === OPERATE ? path : `${path}&tab=${tab}`;
}

/**
 * Where a goal's page is; on a page about several sites that of its site.
 *
 * @param name Of its robot or its action; where it is not known, the goal is looked up.
 */
export function goalPath(goalId: string, name: string | null): string {
  const prefix = name === null ? "" : placeOf(name).prefix;
  return `${prefix}/ui/goals/${encodeURIComponent(goalId)}`;
}
