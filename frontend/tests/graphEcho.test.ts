import { expect, test } from "vitest";
import {
  describeCuts,
  type EchoEvent,
  type EchoMessage,
  type EchoState,
  formatBytes,
  formatRate,
  initialEcho,
  reduceEcho,
} from "../src/graph/echo";
import { topic } from "./graph";

const INSTALLED: EchoEvent = {
  type: "topic",
  time: "2026-01-01T00:00:00Z",
  topic: topic("/chatter"),
  message_type: "std_msgs/msg/String",
  installed: true,
  hint: null,
};

function message(data: string): EchoEvent {
  const time = "2026-01-01T00:00:00Z";
  return { type: "message", time, topic: "/chatter", message: { data }, abbreviated: false, lengths: {} };
}

function rate(hz: number, messages = 1): EchoEvent {
  return {
    type: "rate",
    time: "2026-01-01T00:00:00Z",
    topic: "/chatter",
    rate_hz: hz,
    bytes_per_s: 40,
    messages,
  };
}

function after(state: EchoState, ...events: EchoEvent[]): EchoState {
  return events.reduce((before, event) => reduceEcho(before, { kind: "event", event, now: 0 }), state);
}

test("it is live once the topic has been told, and shows the newest message", () => {
  const state = after(initialEcho(0), INSTALLED, message("a"), message("b"));
  expect(state.connection.phase).toBe("live");
  expect(state.latest).toMatchObject({ message: { data: "b" } });
});

test("a pause holds the message while the rate goes on", () => {
  let state = reduceEcho(after(initialEcho(0), INSTALLED, message("a")), { kind: "pause", now: 1 });
  state = after(state, message("b"), rate(2, 7));
  expect(state.held).toMatchObject({ message: { data: "a" } });
  expect(state.rate?.messages).toBe(7);
  state = reduceEcho(state, { kind: "go on", now: 2 });
  expect(state.held ?? state.latest).toMatchObject({ message: { data: "b" } });
});

test("a package that is missing is said; a rate there is all the same", () => {
  const state = after(initialEcho(0), { ...INSTALLED, installed: false, hint: "Install my_msgs." }, rate(1));
  expect(state.hint).toBe("Install my_msgs.");
  expect(state.rate?.rate_hz).toBe(1);
});

test("a rate from before the connection was lost is not shown", () => {
  const live = after(initialEcho(0), INSTALLED, rate(9));
  const lost = reduceEcho(live, { kind: "connection", input: { kind: "closed" }, now: 1 });
  expect(lost.rate).toBeNull();
  expect(lost.connection.phase).toBe("reconnecting");
});

test("what is cut is said", () => {
  const cut = {
    ...(message("a") as EchoMessage),
    abbreviated: true,
    lengths: { ranges: 720, "points.x": 101 },
  };
  expect(describeCuts(cut)).toBe("ranges has 720 items, points.x has 101 items");
});

test("rates and sizes are short", () => {
  expect([0, 0.5, 12.34, 99.96, 250.4].map(formatRate)).toEqual([
    "0 Hz",
    "0.5 Hz",
    "12.3 Hz",
    "100 Hz",
    "250 Hz",
  ]);
  expect([0, 640, 1234, 34_000_000, 2e12].map(formatBytes)).toEqual([
    "0 B/s",
    "640 B/s",
    "1.2 kB/s",
    "34 MB/s",
    "2,000 GB/s",
  ]);
});
