import { formatPercentage } from "../../battery/words";
import { codeWords } from "../../goal/words";
import { formatDuration, formatter } from "../../ui/time";
import { dayWords, WEEKDAYS } from "../../ui/timesOfDay";
import type { Decision, Rule, RuleMode, Wait } from "./requests";

const clock = formatter({ hour: "2-digit", minute: "2-digit" });

export const MODES: Record<RuleMode, string> = { off: "Off", dry_run: "Dry run", on: "On" };

export const WAITS: Record<Wait, string> = {
  off: "The rule is off",
  battery_ok: "Battery not low",
  battery_unknown: "No current battery state",
  not_due: "Not due now",
  docked: "Docked",
  server_unavailable: "Docking server not available",
  shared_action: "Its docking action is shared with other robots",
  goal_running: "A goal is running",
  goal_lost: "Contact was lost during a goal",
  at_work: "It is on a mission",
  dock_occupied: "Another robot has its dock",
  quiet_period: "Someone has just canceled a goal of it",
  stopped: "Was stopped, and waits until someone lets it continue",
  not_idle: "Not idle long enough",
  retry_later: "Waits 5 minutes after the last attempt",
  reported: "Dry run recorded",
  stop_latched: "Stopped",
  gave_up: "Gave up after three attempts",
  deciding: "Deciding",
  history_unavailable: "The history does not answer",
};

export const OUTCOMES: Record<Decision["outcome"], { words: string; color: string }> = {
  sent: { words: "Sent to dock", color: "green" },
  sending: { words: "Sending", color: "blue" },
  dry_run: { words: "Would dock", color: "blue" },
  held: { words: "Held by a stop", color: "orange" },
  refused: { words: "Refused", color: "red" },
  skipped: { words: "Skipped", color: "gray" },
  gave_up: { words: "Gave up", color: "red" },
};

/** `Battery below 20 % and idle for 1 min`, `At 22:00, Mon–Fri (Europe/Berlin)` */
export function conditionWords({ battery, schedule }: Pick<Rule, "battery" | "schedule">): string {
  if (battery !== null)
    return `Battery below ${formatPercentage(battery.below)} and idle for ${formatDuration(battery.idle_s * 1000)}`;
  if (schedule === null) return "";
  return `At ${schedule.times.join(", ")}, ${daysWords(schedule.weekdays)} (${schedule.time_zone})`;
}

function daysWords(days: readonly string[]): string {
  const all = days.join(" ");
  if (days.length === WEEKDAYS.length) return "every day";
  if (all === WEEKDAYS.slice(0, 5).join(" ")) return "Mon–Fri";
  return days.map(dayWords).join(", ");
}

/** The facts that a decision went by, and why no goal was sent; times in the zone that is shown. */
export function reasonWords(decision: Decision): string {
  return [factWords(decision), whyNot(decision)].filter((words) => words !== "").join(". ");
}

function factWords({ battery, idle_since_at, scheduled_at, decided_at }: Decision): string {
  if (scheduled_at !== null) {
    return `Due at ${clock(Date.parse(scheduled_at))}`;
  }
  const charge = battery === null ? [] : [`Battery ${formatPercentage(battery)}`];
  const idle =
    idle_since_at === null
      ? []
      : [`idle for ${formatDuration(Date.parse(decided_at) - Date.parse(idle_since_at))}`];
  return [...charge, ...idle].join(", ");
}

function whyNot({ outcome, code, detail }: Decision): string {
  if (outcome === "gave_up") return "Three attempts did not dock it";
  if (code === null) return "";
  if (outcome === "held" && detail !== null) return detail.charAt(0).toUpperCase() + detail.slice(1);
  return code in WAITS ? WAITS[code as Wait] : (detail ?? codeWords(code));
}
