import { toCommandError } from "../api/errors";
import type { StopReport } from "../api/types";
import type { Robot } from "../fleet/types";
import { defaultRobot, isUnder } from "./held";

/** Stops one robot and those in namespaces below it; null for the one that the gateway is configured for. */
type StopRobot = (robot: string | null) => Promise<StopReport>;

/**
 * Stops every robot that is known, all at once: the gateway's stop holds for the configured robot and those below it,
 * which is all of them unless it is configured for one of several.
 */
export function stopEverywhere(
  stopRobot: StopRobot,
  robots: ReadonlyMap<string, Robot>,
): Promise<StopReport> {
  const configured = defaultRobot(robots);
  const beside = [...robots.keys()].filter((name) => !isUnder(name, configured));
  return stopEach(stopRobot, [null, ...outermost(beside)], configured);
}

/**
 * Stops these robots, all at once, and those in namespaces below them.
 *
 * @param robots At least one.
 */
export function stopThese(stopRobot: StopRobot, robots: readonly string[]): Promise<StopReport> {
  return stopEach(stopRobot, outermost(robots), "/");
}

/** The names that are not below another one of them. */
function outermost(names: readonly string[]): string[] {
  return names.filter((name) => !names.some((other) => other !== name && isUnder(name, other)));
}

/**
 * Throws the CommandError of the first where not one stop got through.
 *
 * @param configured The robot that null stands for.
 */
async function stopEach(
  stopRobot: StopRobot,
  targets: readonly (string | null)[],
  configured: string,
): Promise<StopReport> {
  const answers = await Promise.allSettled(targets.map((robot) => stopRobot(robot)));
  const reports = answers.flatMap((answer) => (answer.status === "fulfilled" ? [answer.value] : []));
  const [first] = reports;
  if (first === undefined) throw (answers[0] as PromiseRejectedResult).reason;
  const refused = answers.flatMap((answer, index) => {
    if (answer.status === "fulfilled") return [];
    const { code, detail } = toCommandError(answer.reason);
    return [{ action_name: null, robot: targets[index] ?? configured, code, detail }];
  });
  return {
    canceling: reports.flatMap((report) => report.canceling),
    failed: [...refused, ...reports.flatMap((report) => report.failed)],
    unconfirmed: reports.flatMap((report) => report.unconfirmed),
    stop: first.stop,
    warning: reports.find((report) => report.warning !== null)?.warning ?? null,
  };
}
