import createClient, { type Client } from "openapi-fetch";
import { CommandError, fromProblem, unreachable } from "./errors";
import type { paths } from "./schema.gen";

/** The gateway needs at most 1.5 s to miss an action server and 5 s to wait for its answer. */
const COMMAND_TIMEOUT_MS = 12_000;

/** Typed requests, each sent once: a command that arrives late is worse than one that fails. */
export type Http = Client<paths>;

export function createHttp(baseUrl: string): Http {
  return createClient<paths>({ baseUrl, fetch: (request) => globalThis.fetch(request) });
}

/** The signal that ends a request without an answer. */
export function deadline(): AbortSignal {
  return AbortSignal.timeout(COMMAND_TIMEOUT_MS);
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
