import type { Client, EventQuery } from "./client.ts";
import { ClientError } from "./errors.ts";
import { deadline, settle } from "./http.ts";
import type { GatewayEvent, Goal, GoalStatus, LiveGoal } from "./types.ts";

const FINAL: ReadonlySet<GoalStatus> = new Set(["succeeded", "canceled", "aborted", "rejected"]);

/** Nothing can follow. `lost` is not final: the action server may come back and answer. */
export function isFinal(status: GoalStatus): boolean {
  return FINAL.has(status);
}

/** The goal has ended, by what is known. */
export function isTerminal(status: GoalStatus): boolean {
  return status === "lost" || isFinal(status);
}

/** The same for a goal, also in a state that only a newer gateway has. */
function hasEnded(goal: LiveGoal): boolean {
  return goal.finished_at !== null;
}

/** A goal ended, but did not succeed. `state` says how. */
export class GoalFailed extends ClientError {
  override readonly name = "GoalFailed";

  constructor(readonly state: Goal) {
    super(
      state.error?.code ?? state.status,
      `The goal was ${state.status}`,
      state.error?.detail ?? state.goal_id,
    );
  }
}

/** A goal at a gateway, which goes on if the program ends. Iterating yields its feedback until it ends. */
export class GoalHandle {
  readonly #client: Client;

  constructor(
    client: Client,
    /** The goal as the gateway last answered; `refresh` asks again. */
    public state: Goal,
  ) {
    this.#client = client;
  }

  /** The goal's UUID. */
  get id(): string {
    return this.state.goal_id;
  }

  /** Yields feedback messages from `state` on until the goal ends. */
  async *[Symbol.asyncIterator](): AsyncGenerator<Record<string, unknown>, void> {
    if (hasEnded(this.state)) return;
    const after = this.state.last_event_id ?? undefined;
    for await (const event of this.events({ after })) if (event.type === "feedback") yield event.feedback;
    await this.refresh();
  }

  /** Yields events until the goal ends, first a snapshot. Ends with the signal's reason if that is aborted. */
  async *events(
    query: Omit<EventQuery, "goal_id"> = {},
    signal?: AbortSignal,
  ): AsyncGenerator<GatewayEvent, void> {
    let resumed = false;
    for await (const event of this.#client.events({ ...query, goal_id: this.id }, signal)) {
      yield event;
      if (endsGoal(event)) return;
      resumed ||= event.type === "resumed";
      // At another gateway, a stream that resumes can miss a goal's end.
      if (resumed && event.type === "heartbeat" && hasEnded(await this.refresh())) return;
    }
  }

  /** Waits until the goal ends, and returns how. */
  async wait(signal?: AbortSignal): Promise<Goal> {
    if (hasEnded(this.state)) return this.state;
    for await (const _ of this.events({ feedback: false }, signal));
    return this.refresh();
  }

  /** Waits until the goal has succeeded, and returns its state with the result. Throws GoalFailed if it ended otherwise. */
  async result(signal?: AbortSignal): Promise<Goal> {
    const state = await this.wait(signal);
    if (state.status !== "succeeded") throw new GoalFailed(state);
    return state;
  }

  /** Asks the action server to cancel the goal. `wait` returns when it has ended. */
  async cancel(): Promise<Goal> {
    const { http } = this.#client;
    const path = { goal_id: this.id };
    this.state = await this.#client.repeat(() =>
      settle<Goal>(http.POST("/goals/{goal_id}/cancel", { params: { path }, signal: deadline() })),
    );
    return this.state;
  }

  /** Asks the gateway for the state. */
  async refresh(): Promise<Goal> {
    this.state = (await this.#client.goal(this.id)).state;
    return this.state;
  }
}

/** Whether it is the last event of a stream of one goal. */
function endsGoal(event: GatewayEvent): boolean {
  if (event.type === "snapshot") return event.goals.every(hasEnded);
  return event.type === "result" || (event.type === "status" && event.status === "lost");
}
