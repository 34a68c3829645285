import type { Robot } from "@dock-gateway/client";
import type { Attention } from "../../alerts/order";
import { placeOf } from "../../api/places";
import { byName, inOrder, isFound } from "../../fleet/names";
import { isUnreachable, linkOf } from "../../fleet/words";
import { Address, oneOf, optional, text } from "../../ui/address";

/** What the list can be narrowed to. */
export const SHOWS = ["all", "alerts", "running", "docked", "undocked", "stopped", "unreachable"] as const;
type Show = (typeof SHOWS)[number];

export const SHOW_WORDS: Record<Show, string> = {
  all: "All",
  alerts: "With alerts",
  running: "Running a goal",
  docked: "Docked",
  undocked: "Not docked",
  stopped: "Stopped",
  unreachable: "Unreachable",
};

/** A column that the list can be sorted by; it begins with the names, so that a robot stays in its place. */
const SORTS = ["name", "place", "battery", "goal", "last", "groups", "link"] as const;
export type Sort = (typeof SORTS)[number];

/** How the list is looked at; kept in the page's address. */
export interface View {
  show: Show;
  /** A part of the name, the namespace or a group. */
  text: string;
  /** Robots in this group alone; null for all. */
  group: string | null;
  /** At a hub: robots of this site alone; null for all. */
  site: string | null;
  sort: Sort;
  descending: boolean;
  /** Columns that are not shown; null for the choice of this browser. */
  hidden: readonly Sort[] | null;
}

export const overviewView = new Address<View>({
  text: text("q"),
  group: optional("group"),
  site: optional("site"),
  show: oneOf("show", SHOWS, "all"),
  sort: oneOf("sort", SORTS, "name"),
  descending: {
    read: (parameters) => parameters.get("order") === "desc",
    write: (on, parameters) => on && parameters.set("order", "desc"),
  },
  hidden: {
    read: (parameters) => (parameters.has("hide") ? readColumns(parameters.get("hide")?.split(",")) : null),
    write: (columns, parameters) => columns !== null && parameters.set("hide", columns.join()),
  },
});

/** The columns among some names, in one order; none where it is no list. */
export function readColumns(names: unknown): Sort[] {
  return Array.isArray(names) ? SORTS.filter((sort) => names.includes(sort)) : [];
}

/** The robots that have an alert, by name. */
export type Attentions = ReadonlyMap<string, Attention>;

export function matches(robot: Robot, show: Show, attentions: Attentions): boolean {
  switch (show) {
    case "all":
      return true;
    case "alerts":
      return attentions.has(robot.name);
    case "running":
      return robot.goals.length > 0;
    case "docked":
      return robot.docked === true;
    case "undocked":
      return robot.docked === false;
    case "stopped":
      return robot.stop.latched;
    case "unreachable":
      return isUnreachable(robot);
  }
}

/** The robots of a view, in its order; where two are alike, in the order of every page. */
export function listed(robots: readonly Robot[], view: View, attentions: Attentions): Robot[] {
  const sign = view.descending ? -1 : 1;
  const compare = COMPARE[view.sort];
  return robots
    .filter(
      (robot) =>
        isFound(robot, view.text) &&
        (view.group === null || robot.groups.includes(view.group)) &&
        (view.site === null || siteOf(robot) === view.site) &&
        matches(robot, view.show, attentions),
    )
    .sort((a, b) => sign * compare(a, b) || inOrder(a, b));
}

/** Compares two robots, for an ascending order. */
const COMPARE: Record<Sort, (a: Robot, b: Robot) => number> = {
  name: inOrder,
  place: (a, b) => placeRank(a) - placeRank(b),
  battery: (a, b) => chargeOf(a) - chargeOf(b),
  goal: (a, b) => goalRank(a) - goalRank(b),
  last: (a, b) => endOf(a) - endOf(b),
  groups: (a, b) => groupsRank(a) - groupsRank(b) || byName(a.groups.join(), b.groups.join()),
  link: (a, b) => LINK_RANK[linkOf(a)] - LINK_RANK[linkOf(b)],
};

/** The site of a robot; empty where there is one gateway. */
export function siteOf({ name }: Pick<Robot, "name">): string {
  return placeOf(name).site ?? "";
}

function placeRank({ docked }: Robot): number {
  return docked === null ? 2 : docked ? 0 : 1;
}

/** Whole percents, so that robots do not change places all the time; unmeasured ones come last. */
function chargeOf({ battery: { percentage } }: Robot): number {
  return percentage === null ? 1000 : Math.round(percentage * 100);
}

function goalRank({ goals: [goal], stop }: Robot): number {
  if (stop.latched) return 0;
  return goal === undefined ? 2 : 1;
}

/** The last that ended first. */
function endOf({ last_goal }: Robot): number {
  return last_goal === null
    ? Number.MAX_SAFE_INTEGER
    : -Date.parse(last_goal.finished_at ?? last_goal.updated_at);
}

/** The rank by group; robots in no group are last. */
function groupsRank({ groups }: Robot): number {
  return groups.length === 0 ? 1 : 0;
}

const LINK_RANK = {
  away: -1,
  unreachable: 0,
  gone: 1,
  duplicate: 2,
  silent: 3,
  stale: 4,
  battery: 5,
  connected: 6,
} as const;
