import createClient, { type Client } from "openapi-fetch";
import { CommandError, fromProblem, unreachable } from "./errors";
import type { paths } from "./schema.gen";
import { session } from "./session";

/** The gateway needs at most 1.5 s to miss an action server and 5 s to wait for its answer. */
const COMMAND_TIMEOUT_MS = 12_000;

/** Typed requests, each sent once: a command that arrives late is worse than one that fails. */
export type Http = Client<paths>;

export function createHttp(baseUrl: string): Http {
  return createClient<paths>({ baseUrl, fetch: send });
}

/** The answer to a request. Where it is refused without a login, the page asks who it is for. */
async function send(request: Request): Promise<Response> {
  const answer = await globalThis.fetch(request);
  // A login with a wrong token is refused, too.
  if (answer.status === 401 && new URL(request.url).pathname !== "/session") void session.ask();
  return answer;
}

/** The signal that ends a request without an answer. */
export function deadline(timeoutMs = COMMAND_TIMEOUT_MS): AbortSignal {
  return AbortSignal.timeout(timeoutMs);
}

interface Answer<Data> {
  data?: Data;
  error?: unknown;
  response: Response;
}

/** The body of the answer; throws a CommandError for everything that is not a success. */
export async function settle<Data>(request: Promise<Answer<Data>>): Promise<Data> {
  let answer: Answer<Data>;
  try {
    answer = await request;
  } catch (cause) {
    throw cause instanceof CommandError ? cause : unreachable(cause);
  }
  if (!answer.response.ok) throw fromProblem(answer.response.status, answer.error);
  return answer.data as Data;
}
