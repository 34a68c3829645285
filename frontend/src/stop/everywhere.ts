import type { StopReport } from "@dock-gateway/client";
import { useCallback } from "react";
import { whoStops } from "../access/who";
import { toClientError } from "../api/errors";
import { stopsElsewhere } from "../api/places";
import { useFleet } from "../fleet/context";
import { announceStop, showNotice, showStopped } from "./notices";

/** Stops robots and those in namespaces below them. */
type StopRobots = (robots: readonly string[]) => Promise<StopReport>;

/** The longest query, in characters: well below what the gateway and proxies take. */
const MAX_LENGTH = 4000;

/**
 * Stops these robots, all at once, and those in namespaces below them.
 *
 * @param robots At least one.
 */
export function stopThese(stopRobots: StopRobots, robots: readonly string[]): Promise<StopReport> {
  return stopEach(stopRobots, inRequests(robots));
}

/** Groups the names into as few requests as they fit into. */
function inRequests(names: readonly string[]): string[][] {
  const requests: string[][] = [];
  let room = 0;
  for (const name of names) {
    const length = `robot=${encodeURIComponent(name)}&`.length;
    if (length > room) {
      requests.push([]);
      room = MAX_LENGTH;
    }
    room -= length;
    requests.at(-1)?.push(name);
  }
  return requests;
}

/** Throws the ClientError of the first where not one stop got through. */
async function stopEach(
  stopRobots: StopRobots,
  targets: readonly (readonly string[])[],
): Promise<StopReport> {
  const answers = await Promise.allSettled(targets.map((robots) => stopRobots(robots)));
  const reports = answers.flatMap((answer) => (answer.status === "fulfilled" ? [answer.value] : []));
  const [first] = reports;
  if (first === undefined) throw (answers[0] as PromiseRejectedResult).reason;
  const refused = answers.flatMap((answer, index) => {
    if (answer.status === "fulfilled") return [];
    const { code, detail } = toClientError(answer.reason);
    return (targets[index] ?? []).map((robot) => ({ action_name: null, robot, code, detail }));
  });
  const stopped = new Set(reports.flatMap((report) => report.stopped));
  return {
    stopped: [...stopped],
    not_stopped: first.not_stopped.filter((name) => !stopped.has(name)),
    canceling: reports.flatMap((report) => report.canceling),
    failed: [...refused, ...reports.flatMap((report) => report.failed)],
    unconfirmed: reports.flatMap((report) => report.unconfirmed),
    stop: first.stop,
    others: first.others,
    warning: reports.find((report) => report.warning !== null)?.warning ?? null,
  };
}

/** Stops robots at once, all of them for null, and says what came of it. */
export function useStopping(): (robots: readonly string[] | null) => Promise<void> {
  const { http, gateway, store } = useFleet();
  return useCallback(
    async (robots) => {
      const naming = () => store.get("naming");
      const server = stopsElsewhere();
      if (server !== null)
        return announceStop(naming, robots, () => server.stop(http, whoStops(), robots), showNotice);
      const stop = async (some: readonly string[]) => {
        const report = await gateway.stop(whoStops(), some);
        const [first = "/", ...others] = some;
        if (others.length === 0) store.setStop(report.stop, first); // what holds for several comes as an event
        return report;
      };
      const send = () => (robots === null ? stop([]) : stopThese(stop, robots));
      await announceStop(naming, robots, send, showStopped);
    },
    [http, gateway, store],
  );
}
