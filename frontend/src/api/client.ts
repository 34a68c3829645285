import createClient, { type Client } from "openapi-fetch";
import type { Pose } from "../scene/geometry";
import { CommandError, fromProblem, unreachable } from "./errors";
import type { paths } from "./schema.gen";
import type {
  BatteryStateInput,
  Fault,
  Goal,
  GoalPage,
  Publisher,
  Simulator,
  StopReport,
  StopState,
} from "./types";

/** The gateway needs at most 1.5 s to miss an action server and 5 s to wait for its answer. */
const COMMAND_TIMEOUT_MS = 12_000;

/**
 * What can be asked of the gateway. Each call is one HTTP request: nothing is sent again by itself, because a command
 * that arrives late is worse than one that fails. Every failure is a CommandError.
 */
export interface Gateway {
  dock(desiredStatus: number): Promise<Goal>;
  undock(): Promise<Goal>;
  cancel(verb: Verb, goalId: string): Promise<Goal>;
  goal(verb: Verb, goalId: string): Promise<Goal>;
  goals(verb: Verb, cursor: string | null): Promise<GoalPage>;
  /** Stops, and lets nobody go on until `release`. */
  stop(by: string): Promise<StopReport>;
  release(): Promise<StopState>;
  publishOnce(state: BatteryStateInput): Promise<void>;
  publishRepeatedly(state: BatteryStateInput, rateHz: number): Promise<Publisher>;
  stopPublishing(): Promise<void>;
  /** Null where there is no simulator. */
  simulator(): Promise<Simulator | null>;
  resetSimulator(): Promise<void>;
  placeRobot(pose: Pose): Promise<void>;
  switchFault(fault: Fault, active: boolean): Promise<void>;
}

/** The two things that the page asks of a robot, each an action with its own goals. */
export type Verb = "dock" | "undock";

interface Answer<Data> {
  data?: Data;
  error?: unknown;
  response: Response;
}

/** The body of the answer; throws a CommandError for everything that is not a success. */
async function settle<Data>(request: Promise<Answer<Data>>): Promise<Data> {
  let answer: Answer<Data>;
  try {
    answer = await request;
  } catch (cause) {
    throw cause instanceof CommandError ? cause : unreachable(cause);
  }
  if (!answer.response.ok) throw fromProblem(answer.response.status, answer.error);
  return answer.data as Data;
}

export function createGateway(baseUrl: string): Gateway {
  const api: Client<paths> = createClient<paths>({
    baseUrl,
    fetch: (request) => globalThis.fetch(request),
  });
  const signal = () => AbortSignal.timeout(COMMAND_TIMEOUT_MS);

  return {
    dock: (desiredStatus) =>
      settle(
        api.POST("/dock", {
          body: { desired_battery_state: { power_supply_status: desiredStatus } },
          signal: signal(),
        }),
      ),
    undock: () => settle(api.POST("/undock", { signal: signal() })),
    cancel: (verb, goalId) =>
      settle(
        api.POST(`/${verb}/{goal_id}/cancel`, { params: { path: { goal_id: goalId } }, signal: signal() }),
      ),
    goal: (verb, goalId) =>
      settle(api.GET(`/${verb}/{goal_id}`, { params: { path: { goal_id: goalId } }, signal: signal() })),
    goals: (verb, cursor) =>
      settle(
        api.GET(`/${verb}`, {
          params: { query: { limit: 50, ...(cursor === null ? {} : { cursor }) } },
          signal: signal(),
        }),
      ),
    stop: (by) => settle(api.POST("/stop", { body: { by }, signal: signal() })),
    release: () => settle(api.DELETE("/stop", { signal: signal() })),
    publishOnce: async (state) => {
      await settle(api.POST("/battery", { body: state, signal: signal() }));
    },
    publishRepeatedly: (state, rateHz) =>
      settle(api.PUT("/battery/publisher", { body: { state, rate_hz: rateHz }, signal: signal() })),
    stopPublishing: async () => {
      await settle(api.DELETE("/battery/publisher", { signal: signal() }));
    },
    simulator: () =>
      settle<Simulator>(api.GET("/simulator", { signal: signal() })).catch((error: unknown) => {
        if (error instanceof CommandError && error.code === "simulator_not_found") return null;
        throw error;
      }),
    resetSimulator: async () => {
      await settle(api.POST("/simulator/reset", { signal: signal() }));
    },
    placeRobot: async (pose) => {
      await settle(api.POST("/simulator/place", { body: pose, signal: signal() }));
    },
    switchFault: async (fault, active) => {
      await settle(
        api.PUT("/simulator/faults/{fault}", {
          params: { path: { fault } },
          body: { active },
          signal: signal(),
        }),
      );
    },
  };
}
