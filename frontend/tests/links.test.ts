import { describe, expect, it } from "vitest";
import { linkOf } from "../src/fleet/words";
import { robot, server } from "./events";

const heard = robot("/robot1").battery;
const stale = { ...heard, stale: true };
const never = { ...stale, state: null, received_at: null };
const absent = { ...server, available: false, answering: false };
const frozen = { ...server, answering: false };

describe("how a robot can be reached", () => {
  it.each([
    ["connected", server, server, heard],
    ["connected", server, null, never],
    ["silent", server, frozen, heard],
    ["silent", frozen, null, never],
    ["duplicate", { ...server, duplicate: true }, frozen, heard],
    ["gone", absent, null, heard],
    ["battery", null, null, heard],
    ["unreachable", null, null, stale],
    ["unreachable", absent, absent, stale],
    ["unreachable", frozen, frozen, stale],
    ["unreachable", absent, null, never],
  ] as const)("is %s", (link, dock, undock, battery) => {
    expect(linkOf(robot("/robot1", { dock, undock, battery }))).toBe(link);
  });
});
