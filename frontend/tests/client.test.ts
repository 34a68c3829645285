import { ClientError, fromProblem } from "@dock-gateway/client";
import { describe, expect, it, vi } from "vitest";
import { createGateway } from "../src/api/client";
import { adviceFor } from "../src/api/errors";
import { createHttp } from "../src/api/http";
import { goal, released, stopReport } from "./events";

function answer(status: number, body: unknown, type = "application/json") {
  const fetch = vi.fn(async (_request: Request) =>
    status === 204
      ? new Response(null, { status })
      : new Response(typeof body === "string" ? body : JSON.stringify(body), {
          status,
          headers: { "Content-Type": type },
        }),
  );
  vi.stubGlobal("fetch", fetch);
  return fetch;
}

const gateway = createGateway(createHttp("http://gateway:8000"));

async function failure(promise: Promise<unknown>): Promise<ClientError> {
  const error = await promise.then(
    () => null,
    (reason: unknown) => reason,
  );
  if (!(error instanceof ClientError)) throw new Error(`not a ClientError: ${String(error)}`);
  return error;
}

describe("commands", () => {
  it("dock with the desired status", async () => {
    const fetch = answer(202, goal("a"));
    expect((await gateway.dock(4)).goal_id).toBe("a");
    const request = fetch.mock.calls[0]?.[0];
    expect(request?.method).toBe("POST");
    expect(request?.url).toBe("http://gateway:8000/dock");
    expect(await request?.json()).toEqual({ desired_battery_state: { power_supply_status: 4 } });
    await gateway.dock(null, "lab");
    expect(await fetch.mock.calls[1]?.[0].json()).toEqual({ dock_id: "lab" });
  });

  it("stop with the name of who stops, and release", async () => {
    const stopping = answer(200, stopReport());
    expect(await gateway.stop("Ada", [])).toEqual(stopReport());
    expect(await stopping.mock.calls[0]?.[0].json()).toEqual({ by: "Ada" });
    await gateway.stop("Ada", ["/a", "/b"]);
    expect(decodeURIComponent(stopping.mock.calls[1]?.[0].url ?? "")).toMatch(/\/stop\?robot=\/a&robot=\/b$/);
    const releasing = answer(200, released);
    expect(await gateway.release("/a")).toEqual(released);
    expect(releasing.mock.calls[0]?.[0]).toMatchObject({
      method: "DELETE",
      url: "http://gateway:8000/stop?robot=%2Fa",
    });
  });

  it("send a goal to its action, and cancel it whatever its action is", async () => {
    const fetch = answer(202, goal("a"));
    await gateway.undock();
    await gateway.cancel("a");
    expect(fetch.mock.calls.map(([request]) => request.url.replace("http://gateway:8000", ""))).toEqual([
      "/undock",
      "/goals/a/cancel",
    ]);
  });

  it("send each goal with a key of its own", async () => {
    const fetch = answer(202, goal("a"));
    await gateway.dock(1);
    await gateway.dock(1);
    await gateway.undock();
    const keys = fetch.mock.calls.map(([request]) => request.headers.get("Idempotency-Key"));
    expect(new Set(keys).size).toBe(3);
    expect(keys.every((key) => key !== null && key.length > 10)).toBe(true);
  });

  it("publish, repeatedly and no more", async () => {
    const fetch = answer(204, null);
    await gateway.stopPublishing();
    expect(fetch.mock.calls[0]?.[0].method).toBe("DELETE");
    answer(200, { active: true });
    await gateway.publishRepeatedly({ voltage: 2 }, 5);
  });

  it("are sent once, also when they fail", async () => {
    const fetch = vi.fn(async () => Promise.reject(new TypeError("Failed to fetch")));
    vi.stubGlobal("fetch", fetch);
    expect((await failure(gateway.dock(1))).code).toBe("gateway_unreachable");
    expect(fetch).toHaveBeenCalledTimes(1);
  });
});

describe("errors", () => {
  it("carry the gateway's code and sentence, and what to do", async () => {
    answer(
      409,
      { type: "about:blank", title: "Dock busy", status: 409, code: "dock_busy", detail: "goal 1 runs" },
      "application/problem+json",
    );
    const error = await failure(gateway.dock(1));
    expect(error).toMatchObject({ code: "dock_busy", detail: "goal 1 runs" });
    expect(adviceFor(error.code)).toMatch(/cancel it/);
  });

  it("name the fields that are wrong", () => {
    const errors = [{ path: "voltage", expected: "float32", detail: "got a string" }];
    const error = fromProblem(422, { code: "invalid_field", title: "t", status: 422, detail: "d", errors });
    expect(error.fields).toEqual(errors);
  });

  it("keep an unknown code and its title", () => {
    const error = fromProblem(418, { code: "teapot", title: "Teapot", detail: "short and stout" });
    expect(error).toMatchObject({ code: "teapot", title: "Teapot" });
  });

  it("tell a proxy's page from the gateway", async () => {
    answer(502, "<html>Bad gateway</html>", "text/html");
    expect((await failure(gateway.stop("Ada", []))).code).toBe("gateway_unreachable");
    answer(404, "nothing", "text/plain");
    expect((await failure(gateway.stop("Ada", []))).code).toBe("http_error");
  });

  it("tell a time-out from a refused connection", async () => {
    vi.stubGlobal("fetch", async () => Promise.reject(new DOMException("late", "TimeoutError")));
    expect((await failure(gateway.dock(1))).code).toBe("gateway_timeout");
  });
});
