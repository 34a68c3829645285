import type { GatewayEvent, StreamHandlers } from "@dock-gateway/client";
import { act } from "@testing-library/react";

/** The streams of events that a test's pages have opened, the oldest first. */
export const streams: { url: string; handlers: StreamHandlers; closed: boolean }[] = [];

/** In place of that of the page: no gateway sends events here, a test tells them. */
export function openStream(url: string, handlers: StreamHandlers): () => void {
  const stream = { url, handlers, closed: false };
  streams.push(stream);
  return () => {
    stream.closed = true;
  };
}

/** Tells every open stream these events. */
export function tell(...events: GatewayEvent[]): void {
  act(() => {
    for (const { handlers, closed } of streams)
      if (!closed) for (const event of events) handlers.onEvent(event);
  });
}
