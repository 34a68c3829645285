import { useEffect, useReducer } from "react";
import { steadyNow } from "../clock/beat";
import { openStream, streamUrl } from "../stream/stream";
import { type EchoEvent, type EchoInput, type EchoState, initialEcho, reduceEcho } from "./echo";

/** Messages a second that are shown; the rate counts all of them. */
const MAX_RATE = "5";

/** The messages of a topic as they come, for as long as this is mounted. */
export function useEcho(topic: string): [EchoState, (kind: "pause" | "go on") => void] {
  const [state, dispatch] = useReducer(reduceEcho, null, () => initialEcho(steadyNow()));
  useEffect(() => {
    const tell = (input: EchoInput) => dispatch(input);
    const url = streamUrl(window.location, { topic, max_rate: MAX_RATE }, "/ws/topics");
    return openStream(url, {
      // This path has events of its own.
      onEvent: (event) => tell({ kind: "event", event: event as unknown as EchoEvent, now: steadyNow() }),
      onConnection: (input) => tell({ kind: "connection", input, now: steadyNow() }),
    });
  }, [topic]);
  return [state, (kind) => dispatch({ kind, now: steadyNow() })];
}
