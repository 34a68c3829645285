import { EventStream, type StreamHandlers, type StreamOptions } from "@dock-gateway/client";
import { session } from "../api/session";
import { apiPath } from "../api/site";

export type StreamLocation = Pick<Location, "protocol" | "host">;

/** What a stream is about: the query of its path. */
type StreamQuery = Record<string, string | null>;

/** Where the events are, for a page at `location`; what is null is not asked for. */
export function streamUrl(location: StreamLocation, query: StreamQuery, path = "/ws/feedback"): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  const url = new URL(`${scheme}//${location.host}${apiPath(path)}`);
  for (const [name, value] of Object.entries(query)) if (value !== null) url.searchParams.set(name, value);
  return url.href;
}

/** Reads events until the returned function is called. Waits for a login while one is needed. */
export function openStream(url: string, handlers: StreamHandlers, options: StreamOptions = {}): () => void {
  const stream = new EventStream(
    url,
    {
      onEvent: handlers.onEvent,
      onConnection: (input) => {
        handlers.onConnection(input);
        const refused = input.kind === "closed" && input.refused;
        const back = input.kind === "snapshot" && session.state.trouble != null;
        if (refused || back) void session.ask();
      },
    },
    { ...options, before: () => session.loggedIn().then(() => undefined) },
  );
  const retryNow = () => {
    if (!stream.connected) stream.reconnect();
  };
  // TCP would notice only later. Where the gateway is on this computer, it goes on at once.
  const tryAnew = () => stream.reconnect();
  window.addEventListener("online", retryNow);
  window.addEventListener("offline", tryAnew);
  const forget = session.subscribe(() => session.loggedOut && stream.reconnect());

  return () => {
    forget();
    window.removeEventListener("online", retryNow);
    window.removeEventListener("offline", tryAnew);
    stream.close();
  };
}
