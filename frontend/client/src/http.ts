import createClient, { type Client, type ClientOptions } from "openapi-fetch";
import { ClientError, fromProblem, unreachable } from "./errors.ts";
import type { paths } from "./schema.gen.ts";

/** The gateway needs at most 1.5 s to miss an action server and 5 s to wait for its answer. */
export const TIMEOUT_MS = 12_000;

/** Typed requests, each sent once: a command that arrives late is worse than one that fails. */
export type Http = Client<paths>;

export function createHttp(options: ClientOptions): Http {
  return createClient<paths>(options);
}

/** The signal that ends a request without an answer. */
export function deadline(timeoutMs = TIMEOUT_MS): AbortSignal {
  return AbortSignal.timeout(timeoutMs);
}

interface Answer<Data> {
  data?: Data;
  error?: unknown;
  response: Response;
}

/** The body of the answer; throws a ClientError for everything that is not a success. */
export async function settle<Data>(request: Promise<Answer<Data>>): Promise<Data> {
  let answer: Answer<Data>;
  try {
    answer = await request;
  } catch (cause) {
    throw cause instanceof ClientError ? cause : unreachable(cause);
  }
  if (!answer.response.ok) throw fromProblem(answer.response.status, answer.error);
  return answer.data as Data;
}

/**
 * A key for one request: where a proxy or the browser sends it twice, the gateway sends one goal. `crypto.randomUUID` is
 * missing on pages without HTTPS.
 */
export function newKey(): string {
  return Array.from(crypto.getRandomValues(new Uint32Array(4)), (part) => part.toString(36)).join("-");
}

/** `/robot1/dock` as a part of a path: `robot1/dock`. */
export function actionPath(action: string): string {
  return action.replace(/^\//, "").split("/").map(encodeURIComponent).join("/");
}

/** The options of a request about a name on the graph, whose slashes are slashes of the path. */
export function named(name: string) {
  return { pathSerializer: (path: string) => path.replace(/\{\w+\}/, actionPath(name)) };
}

/** The options of a request about a name on the graph that sends `body`, which is JSON already. */
export function rawJson(name: string, body: string) {
  return { ...named(name), body: {}, bodySerializer: () => body };
}
