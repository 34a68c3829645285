import { describe, expect, it } from "vitest";
import { initialFleet, reduceFleet, withStop } from "../src/fleet/store";
import { alert, at, latched, released, robot, snapshot } from "./events";

const NOW = Date.parse(at(0));
const [root, one, two] = [robot("/"), robot("/robot1"), robot("/robot2")];
const start = reduceFleet(initialFleet, snapshot({ robots: [root, one, two], alerts: [alert("a")] }), NOW);
const names = (state: typeof start) => [...state.robots.keys()];

describe("the fleet", () => {
  it("begins with the snapshot's robots and alerts", () => {
    expect(names(start)).toEqual(["/", "/robot1", "/robot2"]);
    expect(start.alerts).toEqual([alert("a")]);
  });

  it("takes up the robots that changed, and keeps the others as they are", () => {
    const changed = robot("/robot1", { docked: true });
    const robots = { type: "robots" as const, time: at(1), robots: [changed], gone: ["/robot2"] };
    const next = reduceFleet(start, robots, NOW);
    expect(names(next)).toEqual(["/", "/robot1"]);
    expect(next.robots.get("/robot1")).toBe(changed);
    expect(next.robots.get("/")).toBe(root);
  });

  it("names the robots anew only when a name or a group changes", () => {
    const robots = { type: "robots" as const, time: at(1), gone: [] };
    const docked = reduceFleet(start, { ...robots, robots: [robot("/robot1", { docked: true })] }, NOW);
    expect(docked.naming).toBe(start.naming);
    const named = reduceFleet(
      docked,
      { ...robots, robots: [robot("/robot1", { display_name: "Left" })] },
      NOW,
    );
    expect(named.naming.fullNameOf("/robot1")).toBe("Left (/robot1)");
  });

  it("knows after a resume only the robots that it is told of then", () => {
    const resumed = reduceFleet(start, { type: "resumed", time: at(1), after: "e", count: 0 }, NOW);
    expect(names(resumed)).toHaveLength(3);
    const all = { type: "robots" as const, time: at(1), robots: [root, one], gone: [] };
    const told = reduceFleet(resumed, all, NOW);
    expect(names(told)).toEqual(["/", "/robot1"]);
    expect(names(reduceFleet(told, { ...all, robots: [two] }, NOW))).toHaveLength(3);
  });

  it("knows at once of the robots below that a stop, or its release, is about", () => {
    const stopped = withStop(start, null, { ...latched("Ada"), robots: ["/", "/robot1"] });
    expect(stopped.stop.by).toBe("Ada");
    expect([...stopped.robots.values()].map(({ stop }) => stop.latched)).toEqual([true, true, false]);
    expect(stopped.robots.get("/robot2")).toBe(two);
    const letGo = withStop(stopped, null, released);
    expect([...letGo.robots.values()].map(({ stop }) => stop.latched)).toEqual([false, false, false]);
    const other = withStop(start, "/robot2", { ...latched("Bob"), robots: ["/robot2"] });
    expect(other.stop).toBe(start.stop);
    expect(other.robots.get("/robot2")?.stop.by).toBe("Bob");
  });
});
