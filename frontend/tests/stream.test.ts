// @vitest-environment jsdom

import { type ConnectionInput, type GatewayEvent, SILENCE_MS } from "@dock-gateway/client";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ANYBODY, session } from "../src/api/session";
import { openStream, streamUrl } from "../src/stream/stream";
import { at, cmdVel, feedback, snapshot } from "./events";

class FakeSocket extends EventTarget {
  static sockets: FakeSocket[] = [];
  readyState = 0;
  binaryType = "blob";
  sent: unknown[] = [];

  constructor(readonly url: string) {
    super();
    FakeSocket.sockets.push(this);
  }
  open() {
    this.readyState = 1;
    this.dispatchEvent(new Event("open"));
  }
  receive(data: unknown) {
    this.dispatchEvent(new MessageEvent("message", { data }));
  }
  drop(code = 1006) {
    this.readyState = 3;
    this.dispatchEvent(new CloseEvent("close", { code }));
  }
  send(data: unknown) {
    this.sent.push(data);
  }
  close() {
    this.readyState = 3;
  }
}

describe("stream", () => {
  let events: GatewayEvent[];
  let inputs: ConnectionInput[];
  let close: () => void;

  async function newest(): Promise<FakeSocket> {
    await vi.advanceTimersByTimeAsync(0);
    const socket = FakeSocket.sockets.at(-1);
    if (!socket) throw new Error("no socket was opened");
    return socket;
  }

  beforeEach(() => {
    vi.useFakeTimers();
    FakeSocket.sockets = [];
    events = [];
    inputs = [];
    close = openStream(
      "ws://gateway/ws/feedback",
      { onEvent: (event) => events.push(event), onConnection: (input) => inputs.push(input) },
      { WebSocket: FakeSocket },
    );
  });
  afterEach(() => close());

  const kinds = () => inputs.map((input) => input.kind).filter((kind) => kind !== "tick");

  it("is live with the snapshot, and hands on events", async () => {
    const socket = await newest();
    socket.open();
    expect(kinds()).toEqual([]);
    socket.receive(JSON.stringify(snapshot()));
    expect(kinds()).toEqual(["snapshot"]);
    socket.receive(JSON.stringify({ type: "heartbeat", id: "1", time: at(1) }));
    expect(events.map((event) => event.type)).toEqual(["snapshot", "heartbeat"]);
  });

  it("says so at once when the connection closes, and reconnects by itself", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(snapshot()));
    socket.drop();
    expect(kinds()).toEqual(["snapshot", "closed"]);
    await vi.advanceTimersByTimeAsync(1000);
    expect(FakeSocket.sockets).toHaveLength(2);
    (await newest()).open();
    (await newest()).receive(JSON.stringify(snapshot()));
    expect(kinds()).toEqual(["snapshot", "closed", "snapshot"]);
  });

  it("goes on after the last event, whatever the order they came in", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(snapshot()));
    const [older, newer] = [feedback("a", 0.1), feedback("a", 0.2)];
    for (const event of [newer, older, cmdVel(0, 0)]) socket.receive(JSON.stringify(event));
    socket.drop();
    await vi.advanceTimersByTimeAsync(1000);
    const second = await newest();
    expect(new URL(second.url).searchParams.get("after")).toBe(newer.id);
    second.open();
    second.receive(JSON.stringify({ type: "resumed", time: at(9), after: newer.id, count: 0 }));
    expect(kinds()).toEqual(["snapshot", "closed", "snapshot"]);
  });

  it("begins anew where the past is gone", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(feedback("a", 0.1)));
    socket.receive(JSON.stringify({ type: "gap", time: at(9), after: "x" }));
    socket.drop();
    await vi.advanceTimersByTimeAsync(1000);
    expect((await newest()).url).toBe("ws://gateway/ws/feedback");
  });

  it("takes a silent connection for dead, and heartbeats for life", async () => {
    const socket = await newest();
    socket.open();
    for (let beat = 0; beat < 4; beat += 1) {
      await vi.advanceTimersByTimeAsync(5000);
      socket.receive(JSON.stringify({ type: "heartbeat", id: "1", time: at(beat) }));
    }
    expect(FakeSocket.sockets).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(SILENCE_MS + 1000);
    expect(kinds()).toContain("closed");
    expect(FakeSocket.sockets).toHaveLength(2);
  });

  it("waits for a login when its token is no longer valid, and goes on at once after it", async () => {
    const out = { required: true, open_to: null, principal: null, provider: null, hub: false, share: [] };
    vi.stubGlobal("fetch", async () => Response.json(out));
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(snapshot()));
    socket.drop(4401);
    await vi.advanceTimersByTimeAsync(60_000);
    expect(session.loggedOut).toBe(true);
    expect(FakeSocket.sockets).toHaveLength(1);
    session.set({ ...ANYBODY, required: true });
    await newest();
    expect(FakeSocket.sockets).toHaveLength(2);
    session.set(ANYBODY);
  });

  it("asks whether a login is needed where a handshake was refused", async () => {
    vi.stubGlobal("fetch", async () =>
      Response.json({
        required: true,
        open_to: null,
        principal: null,
        provider: null,
        share: [],
      }),
    );
    (await newest()).drop();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(FakeSocket.sockets).toHaveLength(1);
    session.set(ANYBODY);
  });

  it("never sends anything", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(snapshot()));
    socket.drop();
    await vi.advanceTimersByTimeAsync(1000);
    (await newest()).open();
    expect(FakeSocket.sockets.flatMap((each) => each.sent)).toEqual([]);
  });

  it("passes on why the gateway closes", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify({ type: "closing", time: at(0), reason: "shutting_down" }));
    expect(inputs).toContainEqual({ kind: "closing", reason: "shutting_down" });
  });

  it("lives through what is not an event", async () => {
    const socket = await newest();
    socket.open();
    for (const data of ["{", "null", "7", new ArrayBuffer(2)]) socket.receive(data);
    expect(events).toEqual([]);
  });

  it("tries at once when the network is back", async () => {
    const socket = await newest();
    socket.open();
    socket.drop();
    window.dispatchEvent(new Event("online"));
    await vi.advanceTimersByTimeAsync(1000);
    expect(FakeSocket.sockets.length).toBeGreaterThanOrEqual(2);
  });

  it("is closed at once when the network is gone, and goes on by itself", async () => {
    const socket = await newest();
    socket.open();
    socket.receive(JSON.stringify(snapshot()));
    window.dispatchEvent(new Event("offline"));
    expect(kinds()).toEqual(["snapshot", "closed"]);
    expect(socket.readyState).toBe(3);
    (await newest()).open();
    (await newest()).receive(JSON.stringify({ type: "resumed", time: at(1), after: "x", count: 0 }));
    expect(kinds()).toEqual(["snapshot", "closed", "snapshot"]);
  });

  it("ends for good when closed", async () => {
    (await newest()).open();
    close();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(FakeSocket.sockets).toHaveLength(1);
  });
});

describe("streamUrl", () => {
  it("follows the page's scheme and host, and asks for what is not null", () => {
    expect(streamUrl({ protocol: "http:", host: "a:8000" }, { robot: "/robot1", action: null })).toBe(
      "ws://a:8000/ws/feedback?robot=%2Frobot1",
    );
    expect(streamUrl({ protocol: "https:", host: "robot" }, {})).toBe("wss://robot/ws/feedback");
  });
});
