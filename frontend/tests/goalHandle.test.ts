import { Client, type ClientError, type GatewayEvent } from "@dock-gateway/client";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { at, feedback, goal, result, status, stopReport } from "./events";

/** A gateway whose streams send what the test says. */
class FakeSocket extends EventTarget {
  static readonly CLOSED = 3;
  static sockets: FakeSocket[] = [];
  readyState = 0;
  binaryType = "blob";

  constructor(readonly url: string) {
    super();
    FakeSocket.sockets.push(this);
  }
  emit(...events: GatewayEvent[]) {
    this.readyState = 1;
    this.dispatchEvent(new Event("open"));
    for (const event of events)
      this.dispatchEvent(new MessageEvent("message", { data: JSON.stringify(event) }));
  }
  drop() {
    this.readyState = 3;
    this.dispatchEvent(new Event("close"));
  }
  close() {
    this.readyState = 3;
  }
}

let requests: Request[];
let answers: Record<string, unknown[]>;

/** Answers in turn, the last one from then on. An Error is a connection that is lost. */
async function fetch(request: Request): Promise<Response> {
  requests.push(request);
  const name = `${request.method} ${new URL(request.url).pathname}`;
  const [answer, ...later] = answers[name] ?? [new Error(`nothing answers ${name}`)];
  if (later.length > 0) answers[name] = later;
  if (answer instanceof Error) throw answer;
  return Response.json(answer);
}

async function nextSocket(count: number): Promise<FakeSocket> {
  await vi.waitFor(() => expect(FakeSocket.sockets.length).toBe(count), { timeout: 30_000 });
  return FakeSocket.sockets[count - 1] as FakeSocket;
}

async function all<T>(items: AsyncIterable<T>): Promise<T[]> {
  const seen: T[] = [];
  for await (const item of items) seen.push(item);
  return seen;
}

const sent = (path: string) => requests.filter(({ url }) => new URL(url).pathname === path);
const gone = new TypeError("fetch failed");
const known = goal("a", { last_event_id: "0" });

beforeEach(() => {
  requests = [];
  FakeSocket.sockets = [];
  answers = { "POST /session/ticket": [{ ticket: "t" }], "GET /robots": [{ robots: [] }] };
  vi.stubGlobal("fetch", fetch);
  vi.stubGlobal("WebSocket", FakeSocket);
});

afterEach(() => vi.unstubAllGlobals());

it("sends a goal again with its key where the connection is lost, and a stop never", async () => {
  const client = new Client({ url: "http://gateway", token: "secret" });
  await client.robots();
  answers["POST /dock"] = [gone, known];
  expect((await client.dock({ dock_id: "lab" })).id).toBe("a");
  const keys = sent("/dock").map(({ headers }) => headers.get("Idempotency-Key"));
  expect(keys).toEqual([keys[0], keys[0]]);
  expect(sent("/dock")[0]?.headers.get("Authorization")).toBe("Bearer secret");
  answers["POST /stop"] = [gone, stopReport()];
  await expect(client.stop()).rejects.toMatchObject({ code: "gateway_unreachable" });
});

it("does not wait for a gateway that never answered", async () => {
  answers = {};
  const client = new Client({ url: "http://gateway" });
  await expect(client.robots()).rejects.toMatchObject({ code: "gateway_unreachable" });
  await expect(client.events().next()).rejects.toMatchObject({ code: "gateway_unreachable" });
  expect(() => new Client({ url: "gateway:8000" })).toThrow(
    "gateway:8000 should be like http://127.0.0.1:8000.",
  );
});

it("goes on after the last feedback, hands on each once, and ends with the goal", async () => {
  answers["GET /goals/a"] = [known, { ...known, status: "succeeded", finished_at: at(3) }];
  const followed = await new Client({ url: "http://gateway", token: "secret" }).goal("a");
  const seen = all(followed);
  const [first, second] = [feedback("a", 1), feedback("a", 2)];
  const one = await nextSocket(1);
  expect(one.url).toBe("ws://gateway/ws/feedback?goal_id=a&after=0&ticket=t");
  one.emit(first);
  one.drop();
  const two = await nextSocket(2);
  expect(new URL(two.url).searchParams.get("after")).toBe(first.id);
  two.emit({ type: "resumed", time: at(2), after: first.id, count: 1 }, first, second, result("a"));
  expect(await seen).toEqual([first.feedback, second.feedback]);
  expect(two.readyState).toBe(FakeSocket.CLOSED);
  expect((await followed.result()).status).toBe("succeeded");
});

it("asks for a goal whose end another gateway did not tell", async () => {
  answers["GET /goals/a"] = [
    known,
    { ...known, status: "aborted", finished_at: at(3), error: { code: "stalled", detail: "No." } },
  ];
  const waiting = (await new Client({ url: "http://gateway" }).goal("a")).result();
  const socket = await nextSocket(1);
  expect(socket.url).not.toContain("ticket");
  socket.emit(
    status("a"),
    { type: "resumed", time: at(2), after: "0", count: 0 },
    { type: "heartbeat", id: "1", time: at(2) },
  );
  const error = await waiting.catch((reason: ClientError) => reason);
  expect(error).toMatchObject({ name: "GoalFailed", code: "stalled", state: { status: "aborted" } });
});

it("ends with the reason of a signal, or where the stream is refused for good", async () => {
  const client = new Client({ url: "http://gateway" });
  const stop = new AbortController();
  const next = client.events({}, stop.signal).next();
  stop.abort(new Error("enough"));
  await expect(next).rejects.toThrow("enough");
  const refused = expect(client.events({ max_rate: -1 }).next()).rejects.toMatchObject({
    code: "stream_refused",
  });
  for (const count of [1, 2, 3]) (await nextSocket(count)).drop();
  await refused;
});

it("calls a service and publishes a message once, at paths with the slashes of their names", async () => {
  const client = new Client({ url: "http://gateway" });
  answers["POST /services/robot1/echo"] = [{ response: { success: true } }, gone];
  answers["POST /topics/robot1/chatter"] = [{ subscribers: 2 }];
  expect(await client.callService("/robot1/echo", { data: true })).toEqual({ success: true });
  expect(await client.publish("/robot1/chatter", { data: "hello" })).toBe(2);
  await expect(client.callService("/robot1/echo")).rejects.toMatchObject({ code: "gateway_unreachable" });
  expect(sent("/services/robot1/echo")).toHaveLength(2);
  expect(await sent("/topics/robot1/chatter")[0]?.json()).toEqual({ data: "hello" });
});
