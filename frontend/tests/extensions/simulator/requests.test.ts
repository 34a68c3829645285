import type { ClientError } from "@dock-gateway/client";
import { expect, it, vi } from "vitest";
import { createHttp } from "../../../src/api/http";
import { createSimulatorApi } from "../../../src/extensions/simulator/requests";
import { simulator } from "../../events";

const api = createSimulatorApi(createHttp("http://gateway:8000"), null);

function answer(status: number, body: object) {
  const fetch = vi.fn(async (_request: Request) => Response.json(body, { status }));
  vi.stubGlobal("fetch", fetch);
  return fetch;
}

it("tells no simulator from one that does not answer", async () => {
  answer(404, { title: "t", status: 404, code: "simulator_not_found", detail: "none" });
  expect(await api.get()).toBeNull();
  answer(503, { title: "t", status: 503, code: "ros_unavailable", detail: "down" });
  const error = await api.get().catch((reason: unknown) => reason);
  expect((error as ClientError).code).toBe("ros_unavailable");
});

it("moves the simulated robot and breaks what is asked", async () => {
  const fetch = answer(200, simulator);
  await api.place({ x: -1, y: 0.5, theta: 0.1 });
  await api.switchFault("stuck_wheel", true);
  const [place, fault] = fetch.mock.calls.map(([request]) => request);
  expect(await place?.json()).toEqual({ x: -1, y: 0.5, theta: 0.1 });
  expect(fault).toMatchObject({ method: "PUT", url: "http://gateway:8000/simulator/faults/stuck_wheel" });
  expect(await fault?.json()).toEqual({ active: true });
});
