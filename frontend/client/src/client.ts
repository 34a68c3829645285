import { ClientError, unreachable } from "./errors.ts";
import { GoalHandle } from "./goal.ts";
import { createHttp, deadline, type Http, named, newKey, settle, TIMEOUT_MS } from "./http.ts";
import type { paths } from "./schema.gen.ts";
import { EventStream } from "./stream.ts";
import type { BatteryAnswer, GatewayEvent, Goal, Include, Robot, StopReport } from "./types.ts";

type Body<Path extends "/dock" | "/undock"> = NonNullable<
  paths[Path]["post"]["requestBody"]
>["content"]["application/json"];

export interface ClientOptions {
  /** Base URL of the gateway. By default that of the page; in Node.js, DOCK_GATEWAY_URL or http://127.0.0.1:8000. */
  url?: string;
  /** The token of a login; in Node.js by default DOCK_GATEWAY_TOKEN. A page of the gateway needs none: it has a cookie. */
  token?: string;
  /** Seconds without the gateway after which a lost connection is given up. */
  patience?: number;
}

export interface SendOptions {
  /** Its namespace; by default the robot that the gateway is configured for. */
  robot?: string;
  /** Goals that are sent with the same key are one. */
  key?: string;
}

/** Selects events, as docs/streams.md says. */
export interface EventQuery {
  goal_id?: string;
  action?: string;
  robot?: string;
  include?: readonly Include[];
  feedback?: boolean;
  max_rate?: number;
  /** Id of the last event that is known: those since then come first, instead of a snapshot. */
  after?: string;
}

/** Events that a stream recognizes if they come again. */
const REMEMBERED = 1000;
/** Attempts in a row after which a stream that never began is given up: a page does not see the answer to a handshake. */
const MAX_REFUSED = 3;
const RETRY_MS = 500;
/** An agent's goal waits that long for a person. */
const APPROVAL_MS = 60_000;

const environment = (globalThis as { process?: { env?: Record<string, string> } }).process?.env ?? {};

/**
 * A client of a gateway. Every failure is a ClientError. If the connection is lost, what can be repeated without harm is
 * repeated until the client's patience ends. A gateway that never answered is not waited for.
 */
export class Client {
  /** Any other request, typed: `await settle(client.http.GET("/statistics", …))`. */
  readonly http: Http;
  readonly #url: URL;
  readonly #token: string | undefined;
  readonly #patienceMs: number;
  #reached = false;

  constructor({ url, token = environment.DOCK_GATEWAY_TOKEN, patience = 60 }: ClientOptions = {}) {
    this.#url = addressOf(url ?? globalThis.location?.origin ?? environment.DOCK_GATEWAY_URL);
    this.#token = token;
    this.#patienceMs = patience * 1000;
    this.http = createHttp({
      baseUrl: this.#url.href.replace(/\/$/, ""),
      headers: token ? { Authorization: `Bearer ${token}` } : {},
    });
  }

  /** Sends a robot to its charging dock. */
  dock(goal?: Body<"/dock">, { robot, key = newKey() }: SendOptions = {}): Promise<GoalHandle> {
    const params = { query: { robot }, header: { "Idempotency-Key": key } };
    return this.#send(() => this.http.POST("/dock", { body: goal, params, signal: deadline() }));
  }

  /** Drives a robot off its charging dock. */
  undock(goal?: Body<"/undock">, { robot, key = newKey() }: SendOptions = {}): Promise<GoalHandle> {
    const params = { query: { robot }, header: { "Idempotency-Key": key } };
    return this.#send(() => this.http.POST("/undock", { body: goal, params, signal: deadline() }));
  }

  /** Sends a goal to any action, such as /fibonacci. `goal` has fields of its goal message. */
  send(action: string, goal: Record<string, unknown>, key = newKey()): Promise<GoalHandle> {
    return this.#send(() =>
      this.http.POST("/actions/{name}/goals", {
        params: { path: { name: action }, header: { "Idempotency-Key": key } },
        ...named(action),
        body: goal as Record<string, never>,
        signal: deadline(),
      }),
    );
  }

  /** A goal that was sent by any client. */
  async goal(goalId: string): Promise<GoalHandle> {
    const path = { goal_id: goalId };
    const asked = () => settle(this.http.GET("/goals/{goal_id}", { params: { path }, signal: deadline() }));
    return new GoalHandle(this, await this.repeat(asked));
  }

  /** All robots on the ROS graph, by name. */
  async robots(): Promise<Robot[]> {
    return (await this.repeat(() => settle(this.http.GET("/robots", { signal: deadline() })))).robots;
  }

  /** The latest battery state of a robot. */
  battery(robot?: string): Promise<BatteryAnswer> {
    return this.repeat(() =>
      settle(this.http.GET("/battery", { params: { query: { robot } }, signal: deadline() })),
    );
  }

  /**
   * Stops robots, by default all: zero velocity, every goal is canceled. It is sent once: after an error the robots may
   * not have stopped.
   *
   * @param options.latch Whether new goals are refused until `release`, which is the default.
   * @param options.by Who stops, shown to others.
   */
  stop(robots: readonly string[] = [], options: { latch?: boolean; by?: string } = {}): Promise<StopReport> {
    const params = { query: { robot: [...robots] }, header: { Prefer: "wait=2" } };
    return settle(this.http.POST("/stop", { params, body: options, signal: deadline() }));
  }

  /** Releases a stop: new goals are accepted again. */
  async release(robot?: string): Promise<void> {
    await settle(this.http.DELETE("/stop", { params: { query: { robot } }, signal: deadline() }));
  }

  /**
   * Calls a ROS service that the gateway's settings allow, and returns its response. It is sent once: after an error the
   * service may have been called.
   *
   * @param timeout Seconds to wait for the response.
   */
  async callService(
    name: string,
    request: Record<string, unknown> = {},
    timeout = 5,
  ): Promise<Record<string, unknown>> {
    const call = this.http.POST("/services/{service}", {
      params: { path: { service: name }, query: { timeout_s: timeout } },
      ...named(name),
      body: request as Record<string, never>,
      signal: deadline((timeout + 10) * 1000),
    });
    return (await settle(call)).response;
  }

  /**
   * Publishes a message on a topic that the gateway's settings allow; returns the number of its subscribers.
   *
   * @param type Such as std_msgs/msg/String; needed only where no one is at the topic.
   */
  async publish(topic: string, message: Record<string, unknown>, type?: string): Promise<number> {
    const call = this.http.POST("/topics/{topic}", {
      params: { path: { topic }, query: { type } },
      ...named(topic),
      body: message as Record<string, never>,
      signal: deadline(),
    });
    return (await settle(call)).subscribers;
  }

  /**
   * Yields events as they happen, first a snapshot; forever, or until the signal is aborted, whose reason is thrown. A
   * lost connection resumes without a gap.
   */
  async *events(
    { after, ...query }: EventQuery = {},
    signal?: AbortSignal,
  ): AsyncGenerator<GatewayEvent, void> {
    const events: GatewayEvent[] = [];
    let failure: { error: unknown } | null = null;
    let wake = () => {};
    const fail = (error: unknown) => {
      failure ??= { error };
      wake();
    };
    const aborted = () => fail(signal?.reason);
    let [heard, refused] = [false, 0];
    let lostAt: number | null = null;
    const lost = (error: unknown) => {
      lostAt ??= performance.now();
      if (!this.#isWorthRepeating(error, lostAt)) fail(error);
    };
    const stream = new EventStream(
      this.#streamUrl(query),
      {
        onEvent: (event) => {
          [heard, refused, lostAt] = [true, 0, null];
          events.push(event);
          wake();
        },
        onConnection: (input) => {
          if (input.kind !== "closed" || failure !== null) return;
          if (input.refused && !heard && ++refused === MAX_REFUSED) fail(new StreamRefused());
          else lost(unreachable("the stream has ended"));
        },
      },
      {
        after,
        before: async () => {
          const ticket = await this.#ticket().catch((error: unknown) => {
            lost(error);
            throw error;
          });
          // Only the gateway that gave it takes it, and there may be several behind one address.
          return this.#token ? ticket : undefined;
        },
      },
    );
    signal?.addEventListener("abort", aborted);
    if (signal?.aborted) aborted();
    try {
      const seen = new Set<string>();
      while (true) {
        for (let event = events.shift(); event !== undefined; event = events.shift())
          if (isNew(event, seen)) yield event;
        if (failure !== null) throw (failure as { error: unknown }).error;
        await new Promise<void>((resolve) => {
          wake = resolve;
        });
      }
    } finally {
      signal?.removeEventListener("abort", aborted);
      stream.close();
    }
  }

  /**
   * Sends a request, and again if the connection was lost: only for what does no harm then.
   *
   * @param rejoinsMs Milliseconds that an answer may take in addition, where a repeated request goes on with the first.
   */
  async repeat<T>(send: () => Promise<T>, rejoinsMs = 0): Promise<T> {
    const begin = performance.now();
    while (true) {
      try {
        const answer = await send();
        this.#reached = true;
        return answer;
      } catch (error) {
        const late = error instanceof ClientError && error.code === "gateway_timeout";
        const rejoins = late && performance.now() - begin < TIMEOUT_MS + rejoinsMs;
        if (!rejoins && !this.#isWorthRepeating(error, begin)) throw error;
        await new Promise((resolve) => setTimeout(resolve, RETRY_MS * (0.5 + Math.random())));
      }
    }
  }

  async #send(send: () => Parameters<typeof settle<Goal>>[0]): Promise<GoalHandle> {
    return new GoalHandle(this, await this.repeat(() => settle<Goal>(send()), APPROVAL_MS));
  }

  /** Opens a stream without a header, which a browser cannot send. Says why if the gateway would refuse the stream. */
  async #ticket(): Promise<string> {
    const { ticket } = await settle(this.http.POST("/session/ticket", { signal: deadline() }));
    this.#reached = true;
    return ticket;
  }

  #streamUrl(query: EventQuery): string {
    const url = new URL(`${this.#url.href.replace(/^http/, "ws").replace(/\/$/, "")}/ws/feedback`);
    for (const [name, value] of Object.entries(query))
      if (value !== undefined) url.searchParams.set(name, String(value));
    return url.href;
  }

  #isWorthRepeating(error: unknown, since: number): boolean {
    const unanswered = error instanceof ClientError && UNANSWERED.has(error.code);
    return unanswered && this.#reached && performance.now() - since < this.#patienceMs;
  }
}

const UNANSWERED: ReadonlySet<string> = new Set(["gateway_unreachable", "gateway_timeout"]);

class StreamRefused extends ClientError {
  constructor() {
    const detail = "Its query may be wrong, or about what this login may not see.";
    super("stream_refused", "The gateway refused the stream", detail);
  }
}

function addressOf(url = "http://127.0.0.1:8000"): URL {
  const address = URL.canParse(url) ? new URL(url) : null;
  if (address?.protocol === "http:" || address?.protocol === "https:") return address;
  const detail = `${url} should be like http://127.0.0.1:8000.`;
  throw new ClientError("invalid_address", "This is not the address of a gateway", detail);
}

/** Whether an event has not come before. */
function isNew(event: GatewayEvent, seen: Set<string>): boolean {
  // The id of a snapshot and of a heartbeat is that of the last event before it.
  if (!("id" in event) || event.id === null || event.type === "snapshot" || event.type === "heartbeat")
    return true;
  if (seen.has(event.id)) return false;
  seen.add(event.id);
  const [oldest] = seen;
  if (seen.size > REMEMBERED && oldest !== undefined) seen.delete(oldest);
  return true;
}
