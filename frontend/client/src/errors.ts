import type { Problem } from "./types.ts";

/** A request or a stream failed: a stable code, what happened, and the fields that are wrong. */
export class ClientError extends Error {
  override readonly name: string = "ClientError";

  /**
   * @param code As in docs/errors.md; `gateway_unreachable` or `gateway_timeout` without an answer, `http_error` for an
   *   answer that is not a gateway's.
   */
  constructor(
    readonly code: string,
    readonly title: string,
    readonly detail: string,
    readonly fields: readonly FieldProblem[] = [],
  ) {
    super(`${title}: ${detail}`);
  }
}

/** What is wrong with a field of what was sent. */
interface FieldProblem {
  path: string;
  expected?: string;
  detail: string;
}

function isProblem(body: unknown): body is Problem {
  return typeof body === "object" && body !== null && "code" in body && typeof body.code === "string";
}

/** The error that an HTTP answer is, also if it is not problem+json (a proxy's page, for example). */
export function fromProblem(status: number, body: unknown): ClientError {
  if (isProblem(body)) return new ClientError(body.code, body.title, body.detail ?? "", body.errors ?? []);
  if (status >= 502 && status <= 504) return unreachable(`HTTP ${status} from something before the gateway`);
  return new ClientError("http_error", "The gateway refused", `It answered with HTTP status ${status}.`);
}

/** The error of a request that got no answer. */
export function unreachable(cause: unknown): ClientError {
  return cause instanceof DOMException && cause.name === "TimeoutError"
    ? new ClientError("gateway_timeout", "The gateway did not answer", "There was no answer in time.")
    : new ClientError(
        "gateway_unreachable",
        "The gateway cannot be reached",
        "The request was NOT delivered, as far as is known.",
      );
}
