import { describe, expect, it } from "vitest";
import { linkOf } from "../src/fleet/words";
import { robot, server } from "./events";

describe("how a robot can be reached", () => {
  it.each([
    ["connected", server, server],
    ["silent", server, { ...server, answering: false }],
    ["duplicate", { ...server, duplicate: true }, { ...server, answering: false }],
    ["gone", { ...server, available: false }, null],
    ["battery", null, null],
  ] as const)("is %s", (link, dock, undock) => {
    expect(linkOf(robot("/robot1", { dock, undock }))).toBe(link);
  });
});
