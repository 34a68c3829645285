import { clockOf } from "../../../ui/time";
import { hasEnded } from "../queue";
import type { Mission, MissionStatus, MissionStep } from "../requests";
import {
  depthOf,
  errorWords,
  holdOf,
  missionName,
  STATUSES,
  STEP_STATES,
  stepPlace,
  stepWords,
} from "../words";
import type { Bar, Period, PlannedBar } from "./bars";

/** Signs that are read besides the colors of missions. */
export const SIGNS: Record<MissionStatus, string> = {
  queued: "",
  running: "▸",
  held: "‖",
  canceling: "–",
  succeeded: "✓",
  failed: "✕",
  canceled: "–",
};

/** `02:00 – 02:10`, `02:00 – now` */
export function periodWords({ from, to }: Period, ended = true): string {
  return `${clockOf(from)} – ${ended ? clockOf(to) : "now"}`;
}

/** `Running, step 2 of 3: Dock`, `Held: paused`, `Failed: obstacle in the way` */
export function stateWords(mission: Mission): string {
  const { words } = STATUSES[mission.status];
  if (mission.status === "failed" && mission.error !== null) return `${words}: ${errorWords(mission.error)}`;
  const step = mission.steps[mission.step];
  if (hasEnded(mission) || step === undefined) return words;
  const hold = holdOf(mission);
  return `${hold === null ? words : hold.title}. ${stepPlace(mission)}: ${stepWords(step)}`;
}

/** How far a step has come, in words, with a sign that is read besides its color. */
interface StepState {
  path: string;
  words: string;
  status: MissionStep["status"];
  state: string;
  sign: string;
}

/** The steps of a mission that are not inside of others. */
export function stepStates({ steps }: Pick<Mission, "steps">): StepState[] {
  return steps
    .filter((step) => depthOf(step) === 0)
    .map((step) => {
      const { words: state, sign } = STEP_STATES[step.status];
      return { path: step.path, words: stepWords(step), status: step.status, state, sign };
    });
}

/** `Planned, 22:00`, `Planned 96 times, 16:00 – 23:55` */
export function plannedWords({ from, to, times }: PlannedBar): string {
  return times === 1 ? `Planned, ${clockOf(from)}` : `Planned ${times} times, ${periodWords({ from, to })}`;
}

/** What a bar is called. */
export function barName(bar: Bar): string {
  return bar.kind === "mission" ? missionName(bar.mission) : bar.schedule.name;
}

/** All that a bar says, for those who do not see it. */
export function barWords(bar: Bar): string {
  if (bar.kind === "planned") return `${barName(bar)}. ${plannedWords(bar)}, by a schedule`;
  const { mission } = bar;
  const steps = stepStates(mission).map(({ words, state }) => `${words}: ${state}`);
  const shown = steps.length > 8 ? [...steps.slice(0, 8), `and ${steps.length - 8} more steps`] : steps;
  return `${barName(bar)}, ${periodWords(bar, hasEnded(mission))}. ${stateWords(mission)}. ${shown.join(", ")}`;
}
