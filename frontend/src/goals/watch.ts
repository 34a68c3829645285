import {
  type ClientError,
  type ConnectionInput,
  type EventOf,
  type GatewayEvent,
  type GoalEvent,
  isFinal,
  type LiveGoal,
  type StreamHandlers,
} from "@dock-gateway/client";
import { toClientError } from "../api/errors";
import type { GoalsApi } from "../api/goals";
import { steadyNow } from "../clock/beat";
import type { StatusEvent } from "../goal/timeline";
import { applyFeedback, applyResult, applyStatus, mergeGoals, snapshotGoals } from "../store/goals";
import type { GoalsState } from "../store/state";
import { Shown } from "../store/streamStore";
import { type Connection, initialConnection, nextConnection } from "../stream/connection";
import { FeedbackLog, type FeedbackRow } from "./feedbackLog";

/** How far the past of the goal is here. */
export interface Past {
  loading: boolean;
  /** Whether the gateway has all of it; null while that is not known. */
  complete: boolean | null;
  error: ClientError | null;
}

export interface WatchTopics {
  goal: LiveGoal | null;
  /** Why there is no goal. */
  error: ClientError | null;
  /** In the order of their ids. */
  statuses: readonly StatusEvent[];
  /** The version of the feedback in `log`. */
  feedback: number;
  past: Past;
  /** Null while the goal cannot change any more. */
  connection: Connection | null;
}

const EMPTY: GoalsState = { goals: new Map(), arrivals: new Map(), stages: new Map() };

/**
 * Follows one goal: its state, and everything that has happened to it. The stream is opened first and the history asked
 * for then, so that nothing is missing between them; what comes both ways is known by its id.
 */
export class GoalWatch {
  readonly log = new FeedbackLog();
  #goals = EMPTY;
  #error: ClientError | null = null;
  #statuses: readonly StatusEvent[] = [];
  #past: Past = { loading: true, complete: null, error: null };
  #connection: Connection | null = null;
  /** The last event that came from the history. */
  #reached: string | null = null;
  #again = false;
  #asking = false;
  #closed = false;
  #closeStream: (() => void) | null = null;
  readonly #shown: Shown<WatchTopics>;

  /**
   * @param openEvents Opens the stream of this goal's events, and gives the function that closes it.
   */
  constructor(
    readonly goalId: string,
    private readonly api: GoalsApi,
    private readonly openEvents: (handlers: StreamHandlers) => () => void,
    private readonly now: () => number = steadyNow,
  ) {
    this.#shown = new Shown(() => this.#topics(), now);
  }

  /** Begins, or tries once more. */
  readonly open = async (): Promise<void> => {
    this.#error = null;
    this.#shown.flush();
    try {
      this.take(await this.api.goal(this.goalId));
    } catch (error) {
      this.#error = toClientError(error);
    }
    if (this.#closed) return;
    this.#shown.flush();
    if (this.#error !== null) return;
    if (this.#ended()) void this.readPast();
    else this.#follow();
  };

  close(): void {
    this.#closed = true;
    this.#closeStream?.();
  }

  /** Takes up what an answer over HTTP says of the goal. */
  take(goal: LiveGoal): void {
    this.#goals = mergeGoals(this.#goals, [goal as LiveGoal]);
    this.#shown.schedule();
  }

  get<T extends keyof WatchTopics>(topic: T): WatchTopics[T] {
    return this.#shown.get(topic);
  }

  subscribe(topic: keyof WatchTopics, listener: () => void): () => void {
    return this.#shown.subscribe(topic, listener);
  }

  /** Asks the gateway for what has happened since it was asked last. */
  readonly readPast = async (): Promise<void> => {
    if (this.#asking) {
      this.#again = true;
      return;
    }
    this.#asking = true;
    this.#past = { ...this.#past, loading: true, error: null };
    this.#shown.schedule();
    try {
      do {
        this.#again = false;
        await this.#readPages();
      } while (this.#again);
      this.#past = { ...this.#past, loading: false };
    } catch (error) {
      this.#past = { ...this.#past, loading: false, error: toClientError(error) };
    }
    this.#asking = false;
    this.#shown.schedule();
  };

  async #readPages(): Promise<void> {
    let more = true;
    while (more && !this.#closed) {
      const page = await this.api.history(this.goalId, this.#reached);
      this.#record(page.events);
      this.#reached = page.events.at(-1)?.id ?? this.#reached;
      this.#past = { ...this.#past, complete: page.complete };
      this.#shown.schedule();
      more = page.next_after !== null;
    }
  }

  #follow(): void {
    this.#connection = initialConnection(this.now());
    this.#closeStream = this.openEvents({ onEvent: this.#onEvent, onConnection: this.#onConnection });
  }

  readonly #onEvent = (event: GatewayEvent): void => {
    this.#apply(event);
    this.#shown.schedule();
  };

  #apply(event: GatewayEvent): void {
    switch (event.type) {
      case "snapshot":
        this.#goals = snapshotGoals(this.#goals, null, event.goals.filter(this.#isThis));
        void this.readPast();
        break;
      case "dropped":
        void this.readPast();
        break;
      case "status":
        if (this.#isThis(event)) this.#goals = applyStatus(this.#goals, event);
        this.#live(event);
        break;
      case "feedback":
        if (this.#isThis(event)) this.#goals = applyFeedback(this.#goals, event);
        this.#live(event);
        break;
      case "result":
        if (this.#isThis(event)) this.#goals = applyResult(this.#goals, event);
        this.#live(event);
        break;
    }
  }

  readonly #isThis = ({ goal_id }: { goal_id: string }): boolean => goal_id === this.goalId;

  #live(event: EventOf<"status"> | EventOf<"feedback"> | EventOf<"result">): void {
    if (!this.#isThis(event)) return;
    this.#record([event as GoalEvent]);
    if (this.#ended()) void this.#finish();
  }

  /** Nothing can follow: the stream is closed, and what it may have left out is asked for. */
  async #finish(): Promise<void> {
    if (this.#closeStream === null) return;
    this.#closeStream();
    this.#closeStream = null;
    this.#connection = null;
    void this.readPast();
    try {
      const goal = (await this.api.goal(this.goalId)) as LiveGoal;
      if (isFinal(goal.status)) this.#goals = { ...EMPTY, goals: new Map([[goal.goal_id, goal]]) };
    } catch {
      // The events of the stream are shown.
    }
    this.#shown.schedule();
  }

  #ended(): boolean {
    const goal = this.#goals.goals.get(this.goalId);
    return goal !== undefined && isFinal(goal.status);
  }

  #record(events: readonly GoalEvent[]): void {
    this.log.add(events.flatMap(rowOf));
    const told = events.filter((event) => event.type === "status");
    if (told.length === 0) return;
    const byId = new Map([...this.#statuses, ...told].map((event) => [event.id, event]));
    this.#statuses = [...byId.values()].sort((a, b) => (a.id < b.id ? -1 : 1));
  }

  readonly #onConnection = (input: ConnectionInput): void => {
    if (this.#connection === null) return;
    this.#connection = nextConnection(this.#connection, input, this.now());
    this.#shown.schedule();
  };

  #topics(): WatchTopics {
    return {
      goal: (this.#goals.goals.get(this.goalId) as LiveGoal | undefined) ?? null,
      error: this.#error,
      statuses: this.#statuses,
      feedback: this.log.version,
      past: this.#past,
      connection: this.#connection,
    };
  }
}

function rowOf(event: GoalEvent): FeedbackRow[] {
  if (event.type !== "feedback") return [];
  return [{ id: event.id, time: Date.parse(event.time), message: event.feedback }];
}
