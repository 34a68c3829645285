import type { ClientError, StopReport } from "@dock-gateway/client";
import { notifications, notificationsStore } from "@mantine/notifications";
import { titleOf, toClientError } from "../api/errors";
import type { StopNotice } from "../api/places";
import type { Naming } from "../fleet/names";

const NOTICE = "stop ";

interface Notice extends StopNotice {
  loading?: boolean;
  /** It is replaced once the gateway has said again what is stopped. */
  "data-undelivered"?: true;
}

/** The robots that a Stop is for; null for all of them. */
type Stopped = readonly string[] | null;

/** All notices, also those that wait because there is no room for them. */
function allNotices() {
  const { notifications: shown, queue } = notificationsStore.getState();
  return [...shown, ...queue];
}

/** Shows what became of a Stop. It replaces what was said before of the same robots, and of every robot where it is about all. */
function show(robots: Stopped, notice: Notice): void {
  const id = `${NOTICE}${robots?.join(" ") ?? ""}`;
  for (const { id: known } of allNotices())
    if (known !== undefined && (robots === null ? known.startsWith(NOTICE) : known === id))
      notifications.hide(known);
  // Before all other notices, the newest first: there is room for a few only.
  notifications.show({
    id,
    priority: performance.now(),
    closeButtonProps: { "aria-label": "Dismiss" },
    ...notice,
  });
}

/** Shows what came of a Stop that this page's own gateway did not carry out. */
export function showNotice(notice: StopNotice, _naming: Naming, robots: Stopped): void {
  show(robots, notice);
}

/** `Left forklift (/robot1)`, `12 robots`; null for all of them. */
function wordsOf(robots: Stopped, naming: Naming): string | null {
  const [only] = robots ?? [];
  if (robots === null || only === undefined) return null;
  return robots.length === 1 ? naming.fullNameOf(only) : `${robots.length} robots`;
}

/** Sends a Stop and shows what becomes of it, whichever page is open by then. */
export async function announceStop<Report>(
  namingNow: () => Naming,
  robots: Stopped,
  send: () => Promise<Report>,
  say: (report: Report, naming: Naming, robots: Stopped) => void,
): Promise<void> {
  showStopping(namingNow(), robots);
  try {
    say(await send(), namingNow(), robots);
  } catch (error) {
    showFailed(toClientError(error), namingNow(), robots);
  }
}

/** Shown at once, before the gateway has answered. */
function showStopping(naming: Naming, robots: Stopped): void {
  const what = wordsOf(robots, naming);
  show(robots, {
    color: "red",
    title: what === null ? "Stopping …" : `Stopping ${what} …`,
    message: "Sent to the gateway.",
    autoClose: false,
    loading: true,
  });
}

export function showStopped(
  { canceling, failed, unconfirmed, others, warning }: StopReport,
  naming: Naming,
  robots: Stopped = null,
): void {
  const warned = warning === null ? "" : ` Warning: ${warning.detail} (${warning.code}).`;
  if (failed.length > 0) {
    const unreached = failed.some(({ robot, code }) => robot !== null && code !== "latch_not_published");
    const unheld = failed.some(({ code }) => code === "latch_not_published");
    const failures = failed.map((failure) => {
      const { action_name, robot, detail, code } = failure;
      return `${action_name ?? naming.fullNameOf(robot ?? "/")}: ${detail} (${code})`;
    });
    show(robots, {
      color: "red",
      title: unreached
        ? "Stop did not reach every robot"
        : unheld
          ? "Zero velocity was sent, but the stop could not be published to the robot's nodes"
          : "Zero velocity was sent, but not every goal is canceled",
      message: `${failures.join("; ")}. Use the robot's own emergency stop if it moves.${warned}`,
      autoClose: false,
    });
    return;
  }
  const goals =
    canceling.length === 0
      ? "No goal was running."
      : canceling.length === 1
        ? "One goal is being canceled."
        : `${canceling.length} goals are being canceled.`;
  const waiting = unconfirmed.length === 0 ? goals : `Not answered yet: ${unconfirmed.join(", ")}; retrying.`;
  const what = wordsOf(robots, naming);
  const stopped = what === null ? "Stopped" : `Stopped ${what}`;
  show(robots, {
    color: unconfirmed.length === 0 && warning === null ? "green" : "orange",
    title: warning === null ? stopped : `${stopped}, with a warning`,
    message: `Zero velocity was sent. ${waiting}${wordsOfOthers(others)}${warned}`,
    autoClose: warning === null ? 8000 : false,
  });
}

/** What of the robots that other gateways serve. */
function wordsOfOthers(others: StopReport["others"]): string {
  const names = others.map(({ address, host }) => address ?? host);
  return names.length === 0 ? "" : ` Other gateways stop their own robots: ${names.join(", ")}.`;
}

/** @param robots Those that were to stop. */
function showFailed(error: ClientError, naming: Naming, robots: Stopped): void {
  const what = wordsOf(robots, naming);
  show(robots, {
    color: "red",
    title: `Stop was NOT delivered to ${what ?? "any robot"}`,
    message: `Use the robot's own emergency stop if it moves. ${titleOf(error)} (${error.code}): ${error.detail}`,
    autoClose: false,
    "data-undelivered": true,
  });
}

/**
 * Replaces the notices of failed Stops once the gateway has said again what is stopped.
 *
 * @param stopped The robots that a stop holds.
 */
export function showRecovered(stopped: readonly string[], naming: Naming): void {
  if (!allNotices().some((notice) => notice["data-undelivered"])) return;
  show(null, {
    color: "orange",
    title: "The gateway answers again",
    message:
      stopped.length > 0
        ? `Stopped: ${stopped.map((robot) => naming.fullNameOf(robot)).join(", ")}.`
        : "No robot is stopped. Press Stop again if it is still needed.",
    autoClose: 8000,
  });
}
