import createClient, { type Client } from "openapi-fetch";
import { CommandError, fromProblem, unreachable } from "./errors";
import type { paths } from "./schema.gen";
import type { BatteryStateInput, Goal, GoalPage, Publisher, StopReport } from "./types";

/** The gateway needs at most 1.5 s to miss an action server and 5 s to wait for its answer. */
const COMMAND_TIMEOUT_MS = 12_000;

/**
 * What can be asked of the gateway. Each call is one HTTP request: nothing is sent again by itself, because a command
 * that arrives late is worse than one that fails. Every failure is a CommandError.
 */
export interface Gateway {
  dock(desiredStatus: number): Promise<Goal>;
  cancel(goalId: string): Promise<Goal>;
  stop(): Promise<StopReport>;
  goal(goalId: string): Promise<Goal>;
  goals(cursor: string | null): Promise<GoalPage>;
  publishOnce(state: BatteryStateInput): Promise<void>;
  publishRepeatedly(state: BatteryStateInput, rateHz: number): Promise<Publisher>;
  stopPublishing(): Promise<void>;
}

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
    cancel: (goalId) =>
      settle(api.POST("/dock/{goal_id}/cancel", { params: { path: { goal_id: goalId } }, signal: signal() })),
    stop: () => settle(api.POST("/stop", { signal: signal() })),
    goal: (goalId) =>
      settle(api.GET("/dock/{goal_id}", { params: { path: { goal_id: goalId } }, signal: signal() })),
    goals: (cursor) =>
      settle(
        api.GET("/dock", {
          params: { query: { limit: 50, ...(cursor === null ? {} : { cursor }) } },
          signal: signal(),
        }),
      ),
    publishOnce: async (state) => {
      await settle(api.POST("/battery", { body: state, signal: signal() }));
    },
    publishRepeatedly: (state, rateHz) =>
      settle(api.PUT("/battery/publisher", { body: { state, rate_hz: rateHz }, signal: signal() })),
    stopPublishing: async () => {
      await settle(api.DELETE("/battery/publisher", { signal: signal() }));
    },
  };
}
