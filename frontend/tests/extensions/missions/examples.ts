import { vi } from "vitest";
import type { Mission, MissionStep } from "../../../src/extensions/missions/requests";

export const NOW = Date.parse("2026-11-30T03:00:00Z");
export const DOCK: MissionStep = {
  path: "0",
  repeat: null,
  first_that_works: null,
  name: null,
  dock: {},
  undock: null,
  action: null,
  navigate: null,
  call: null,
  publish: null,
  notify: null,
  wait: null,
  timeout_s: null,
  tries: 1,
  on_failure: "end",
  interruptible: false,
  status: "waiting",
  attempt: 0,
  drives_to: null,
  goal_id: null,
  started_at: null,
  finished_at: null,
  error: null,
};
export const WAIT = { seconds: null, until: null, battery: null, person: false };
export const CHARGE: MissionStep = { ...DOCK, path: "1", dock: null, wait: { ...WAIT, battery: 0.8 } };
export const COUNT: MissionStep = {
  ...DOCK,
  path: "2",
  dock: null,
  action: { name: "/fibonacci", goal: { order: 5 } },
};
export const PLACE = { x: 1.5, y: -2, yaw: Math.PI / 2, frame: "map" };
export const DRIVE: MissionStep = {
  ...DOCK,
  dock: null,
  navigate: { place: null, pose: PLACE, poses: null },
};
export const SHELF = { place: "shelf", pose: null, poses: null };
export const CALL: MissionStep = {
  ...DOCK,
  dock: null,
  call: { service: "/reset", request: { data: true }, type: null },
};
export const PUBLISH: MissionStep = {
  ...DOCK,
  dock: null,
  publish: { topic: "/light", message: {}, type: "std_msgs/msg/Bool" },
};
export const NOTIFY: MissionStep = { ...DOCK, dock: null, notify: { text: "Load me", critical: true } };
export const BLOCK: MissionStep = { ...DOCK, dock: null };
export const NESTED: MissionStep[] = [
  { ...BLOCK, path: "0", repeat: { times: null, round: 7 }, on_failure: { go_to: "home" } },
  { ...BLOCK, path: "0.repeat.steps.0", first_that_works: { alternatives: 2 }, on_failure: "next" },
  { ...DOCK, path: "0.repeat.steps.0.first_that_works.0", dock: { dock_id: "a" }, tries: 3 },
  { ...DOCK, path: "0.repeat.steps.0.first_that_works.1" },
  { ...CHARGE, path: "0.repeat.steps.1" },
  { ...DOCK, path: "1", name: "home" },
];
export const NIGHT: Mission = {
  mission_id: "a",
  etag: '"0"',
  robot: "/robot1",
  group: null,
  name: "Night",
  priority: 50,
  order: 1,
  battery: null,
  status: "running",
  held_for: null,
  pausing: false,
  wait_at: null,
  step: 0,
  error: null,
  template: null,
  arguments: null,
  schedule: null,
  created_by: "Ada",
  created_at: "2026-11-30T02:00:00Z",
  started_at: "2026-11-30T02:00:01Z",
  finished_at: null,
  waits_for: "goal",
  recharge: null,
  steps: [
    { ...DOCK, status: "running", attempt: 1, goal_id: "3f0c", started_at: "2026-11-30T02:00:02Z" },
    CHARGE,
    COUNT,
  ],
};
export const QUEUED: Mission = {
  ...NIGHT,
  mission_id: "b",
  name: null,
  status: "queued",
  started_at: null,
  waits_for: "turn",
  steps: [DOCK],
};
export const ANY: Mission = {
  ...QUEUED,
  mission_id: "any",
  robot: null,
  group: "pickers",
  waits_for: "robot",
};
export const LIMITS = { below: 0.25, charge_to: 0.8 };
export const BREAK: NonNullable<Mission["recharge"]> = {
  number: 1,
  stage: "charging",
  started_at: "2026-11-30T02:30:00Z",
  tried: 0,
  goal_id: null,
  error: null,
};
export const CHARGING: Mission = { ...NIGHT, battery: LIMITS, recharge: BREAK, waits_for: "battery" };
export const HELD: Mission = { ...NIGHT, status: "held", held_for: "stop", waits_for: "continue" };
export const FAILED: Mission = {
  ...NIGHT,
  mission_id: "c",
  name: "Round",
  status: "failed",
  error: { code: "step_timeout", detail: "the step took longer than its timeout_s" },
  finished_at: "2026-11-30T02:10:01Z",
  waits_for: null,
};

/** A gateway with these missions; it remembers what it is asked to do. */
export function answering(missions: Mission[], refuse?: { path: string; detail: string }) {
  const asked: { path: string; body: string }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const { pathname, searchParams } = new URL(request.url);
    if (request.method === "POST") {
      asked.push({ path: pathname + new URL(request.url).search, body: await request.text() });
      if (refuse === undefined) return Response.json(missions[0] ?? QUEUED, { status: 201 });
      const problem = { status: 422, code: "invalid_field", title: "Invalid field", detail: refuse.detail };
      return Response.json({ ...problem, errors: [{ in: "body", ...refuse }] }, { status: 422 });
    }
    const wanted = searchParams.getAll("status");
    const found = missions.filter(({ status }) => wanted.includes(status));
    if (pathname === "/missions") return Response.json({ missions: found, next_cursor: null });
    const one = missions.find(({ mission_id }) => pathname === `/missions/${mission_id}`);
    return one === undefined ? Response.json({}, { status: 404 }) : Response.json(one);
  });
  return asked;
}
