import { createHttp as createClientHttp, type Http } from "@dock-gateway/client";
import { session } from "./session";

export function createHttp(baseUrl: string): Http {
  return createClientHttp({ baseUrl, fetch: send });
}

/** The answer to a request. Where it is refused without a login, the page asks who it is for. */
async function send(request: Request): Promise<Response> {
  const answer = await globalThis.fetch(request);
  // A login with a wrong token is refused, too.
  if (answer.status === 401 && new URL(request.url).pathname !== "/session") void session.ask();
  return answer;
}
