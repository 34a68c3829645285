import { type ActionInfo, actionPath, type LiveGoal, type Robot } from "@dock-gateway/client";
import { goalPath, inOrder, isFound, Naming, namespaceWords, robotName, robotPath } from "../fleet/names";
import { goalTitle } from "../goal/words";
import { OPERATION_NAMES, type Operation, operationsHere, whyNot } from "../operations/operation";

/** Something that the search leads to or does. */
export interface Item {
  id: string;
  label: string;
  description: string | null;
  /** A page, or an operation: on some robots, or on every robot for null. */
  does: { to: string } | { operation: Operation; names: readonly string[] | null };
}

interface ItemGroup {
  label: string;
  items: readonly Item[];
}

interface HelpItem {
  to: string;
  title: string;
  page: string;
}

/** What is searched. */
export interface Sources {
  robots: readonly Robot[];
  groups: readonly string[];
  actions: readonly ActionInfo[];
  /** The goals whose id begins with what is typed. */
  goals: readonly LiveGoal[];
  pages: readonly { to: string; name: string }[];
  /** The headings of the help. */
  help: readonly HelpItem[];
  live: boolean;
}

/** The most results of each kind. */
const MOST = 8;

/** A text this short is in too many headings of the help. */
const SHORT = 3;

/** Robots that are found among so few are offered all commands. */
const FEW = 3;

/** The beginning of a goal id, as `GET /goals?id=` takes it; null where the text is none. */
export function goalIdOf(text: string): string | null {
  const typed = text.trim();
  return /^(?:[0-9a-f]-?){4,32}$/i.test(typed) ? typed : null;
}

/**
 * What is found, the most likely first; groups without an item are left out. A command comes first only where its verb is
 * typed: Enter after a robot's name leads to its page, and does not move it.
 */
export function find(text: string, sources: Sources): ItemGroup[] {
  const wanted = text.trim().toLowerCase();
  const command = commandOf(wanted);
  if (command !== null) {
    const found = ranked(sources.robots, command.rest);
    return filled([{ label: "Commands", items: commandItems(command, found, sources.live) }]);
  }
  const robots = ranked(sources.robots, wanted);
  return filled([
    { label: "Robots", items: robots.slice(0, MOST).map(robotItem) },
    { label: "Commands", items: wanted === "" ? [] : commandsFor(robots, sources.live) },
    { label: "Groups", items: sources.groups.filter(has(wanted)).slice(0, MOST).map(groupItem) },
    { label: "Pages", items: sources.pages.filter(({ name }) => has(wanted)(name)).map(pageItem) },
    { label: "Actions", items: wanted === "" ? [] : actionItems(sources.actions, wanted) },
    {
      label: "Goals",
      items: sources.goals.slice(0, MOST).map((goal) => goalItem(goal, new Naming(sources.robots))),
    },
    { label: "Help", items: wanted.length < SHORT ? [] : helpItems(sources.help, wanted) },
  ]);
}

function filled(groups: ItemGroup[]): ItemGroup[] {
  return groups.filter(({ items }) => items.length > 0);
}

interface Command {
  operation: Operation;
  /** What follows the verb: a part of a robot's name. */
  rest: string;
}

/** `dock robot2` */
function commandOf(wanted: string): Command | null {
  const [verb = "", ...rest] = wanted.split(/\s+/);
  const operation = operationsHere().find((each) => each === verb);
  return operation === undefined ? null : { operation, rest: rest.join(" ") };
}

function commandItems({ operation, rest }: Command, found: readonly Robot[], live: boolean): Item[] {
  const all = operation === "stop" && rest === "" ? [STOP_ALL] : [];
  return [...all, ...found.slice(0, MOST).map((robot) => commandItem(operation, robot, live))];
}

function commandsFor(found: readonly Robot[], live: boolean): Item[] {
  if (found.length > FEW) return [];
  return found.flatMap((robot) => operationsHere().map((operation) => commandItem(operation, robot, live)));
}

const STOP_ALL: Item = {
  id: "stop",
  label: "Stop every robot",
  description: "At once, as the Stop in the header",
  does: { operation: "stop", names: null },
};

function commandItem(operation: Operation, robot: Robot, live: boolean): Item {
  const reason = whyNot(operation, robot, live);
  return {
    id: `${operation} ${robot.name}`,
    label: `${OPERATION_NAMES[operation]} ${robotName(robot)}`,
    description: reason ?? (operation === "stop" ? "At once" : besides(robot)),
    does: { operation, names: [robot.name] },
  };
}

function robotItem(robot: Robot): Item {
  return {
    id: `robot ${robot.name}`,
    label: robotName(robot),
    description: besides(robot),
    does: { to: robotPath(robot.name) },
  };
}

/** The namespace of a robot that has a display name. */
function besides({ name, display_name }: Robot): string | null {
  return display_name === null ? null : name;
}

function groupItem(group: string): Item {
  return {
    id: `group ${group}`,
    label: group,
    description: "Its robots on the overview",
    does: { to: `/?group=${encodeURIComponent(group)}` },
  };
}

function pageItem({ to, name }: { to: string; name: string }): Item {
  return { id: `page ${to}`, label: name, description: null, does: { to } };
}

function helpItems(help: readonly HelpItem[], wanted: string): Item[] {
  return help
    .filter(({ title }) => has(wanted)(title))
    .slice(0, MOST)
    .map(({ to, title, page }) => ({
      id: `help ${to}`,
      label: title,
      description: `Help: ${page}`,
      does: { to },
    }));
}

function actionItems(actions: readonly ActionInfo[], wanted: string): Item[] {
  return actions
    .filter(({ action_name, action_type }) => has(wanted)(action_name) || has(wanted)(action_type))
    .slice(0, MOST)
    .map(({ action_name, action_type }) => ({
      id: `action ${action_name}`,
      label: action_name,
      description: action_type,
      does: { to: `/ui/actions/${actionPath(action_name)}` },
    }));
}

function goalItem(goal: LiveGoal, naming: Naming): Item {
  const { goal_id, action_name, status } = goal;
  return {
    id: `goal ${goal_id}`,
    label: `Goal ${goal_id.slice(0, 8)}`,
    description: `${goalTitle(goal, naming)}, ${status}`,
    does: { to: goalPath(goal_id, action_name) },
  };
}

function has(wanted: string): (text: string) => boolean {
  return (text) => text.toLowerCase().includes(wanted);
}

/** The robots whose name or group has the text: those that are called so first, then those that begin with it. */
function ranked(robots: readonly Robot[], text: string): Robot[] {
  const rank = (robot: Robot) => {
    const names = [robotName(robot), namespaceWords(robot.name), robot.name.replace(/^\//, "")];
    const lower = names.map((name) => name.toLowerCase());
    return lower.includes(text) ? 0 : lower.some((name) => name.startsWith(text)) ? 1 : 2;
  };
  return robots.filter((robot) => isFound(robot, text)).sort((a, b) => rank(a) - rank(b) || inOrder(a, b));
}
