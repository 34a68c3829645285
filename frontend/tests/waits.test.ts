import { Client, type ClientError } from "@dock-gateway/client";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { goal } from "./events";

/** What no answer within its deadline takes, in milliseconds. */
const TIMEOUT = 12_000;
const answer = (body: unknown) => new Response(JSON.stringify(body), { status: 200 });

/** Lets every request time out, but those of which `answered` has the answer, by their number. */
function timeOut(answered: Record<number, unknown> = {}) {
  const fetch = vi.fn(async (_: Request) => {
    const found = answered[fetch.mock.calls.length];
    if (found !== undefined) return answer(found);
    vi.advanceTimersByTime(TIMEOUT);
    throw new DOMException("late", "TimeoutError");
  });
  vi.stubGlobal("fetch", fetch);
  return fetch;
}

async function settled(asked: Promise<unknown>): Promise<unknown> {
  const ended = asked.catch((error: ClientError) => error.code);
  await vi.runAllTimersAsync();
  return ended;
}

describe("a client waits", () => {
  beforeEach(() => {
    vi.useFakeTimers({ toFake: ["setTimeout", "performance"] });
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it("for a person who has to allow a goal, and asks again with the same key", async () => {
    const fetch = timeOut({ 4: goal("a") });
    expect(await settled(new Client({ url: "http://gateway" }).dock())).toMatchObject({ id: "a" });
    expect(new Set(fetch.mock.calls.map(([request]) => request.headers.get("Idempotency-Key"))).size).toBe(1);
  });

  it("no longer than a person may take", async () => {
    timeOut();
    const client = new Client({ url: "http://gateway" });
    const begin = performance.now();
    expect(await settled(client.send("/fibonacci", {}))).toBe("gateway_timeout");
    expect(performance.now() - begin).toBeGreaterThanOrEqual(72_000);
    expect(performance.now() - begin).toBeLessThan(90_000);
  });

  it("once for everything else, at a gateway that never answered", async () => {
    for (const ask of [
      (client: Client) => client.robots(),
      (client: Client) => client.battery(),
      (client: Client) => client.stop(),
      (client: Client) => client.release(),
      (client: Client) => client.goal("a"),
      (client: Client) => client.callService("/reset", {}, 30),
      (client: Client) => client.publish("/chatter", {}),
    ]) {
      const fetch = timeOut();
      expect(await settled(ask(new Client({ url: "http://gateway" })))).toBe("gateway_timeout");
      expect(fetch).toHaveBeenCalledTimes(1);
    }
  });

  it("for a service as long as was asked, and somewhat longer", async () => {
    const limits = vi.spyOn(AbortSignal, "timeout");
    timeOut();
    await settled(new Client({ url: "http://gateway" }).callService("/reset", {}, 300));
    expect(limits.mock.calls.at(-1)?.[0]).toBeGreaterThan(300_000);
    limits.mockRestore();
  });
});
