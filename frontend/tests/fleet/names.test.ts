import { describe, expect, it } from "vitest";
import { isFound, type Label, Naming } from "../../src/fleet/names";

const forklift: Label = { name: "/robot1", display_name: "Left forklift", groups: ["Hall 1", "forklifts"] };
const plain: Label = { name: "/robot2", display_name: null, groups: ["Hall 1"] };
const root: Label = { name: "/", display_name: null, groups: [] };
const naming = new Naming([forklift, plain, root]);

describe("the name of a robot", () => {
  it("is its display name, else its namespace", () => {
    expect(["/robot1", "/robot2", "/", "/gone"].map((robot) => naming.nameOf(robot))).toEqual([
      "Left forklift",
      "/robot2",
      "Robot",
      "/gone",
    ]);
  });

  it("comes with the namespace where that is another", () => {
    expect(naming.fullNameOf("/robot1")).toBe("Left forklift (/robot1)");
    expect(naming.fullNameOf("/robot2")).toBe("/robot2");
    expect(naming.besides("/")).toBeNull();
  });
});

it("stays the same object until a name or a group changes", () => {
  const robots = (...labels: Label[]) => new Map(labels.map((label) => [label.name, label]));
  expect(naming.updated(robots(root, { ...plain }, { ...forklift, groups: [...forklift.groups] }))).toBe(
    naming,
  );
  for (const other of [
    robots(forklift, plain),
    robots(forklift, plain, root, { ...plain, name: "/robot3" }),
    robots({ ...forklift, display_name: "Forklift" }, plain, root),
    robots(forklift, { ...plain, groups: [] }, root),
    robots(forklift, plain, { ...root, name: "/robot3" }),
  ])
    expect(naming.updated(other)).not.toBe(naming);
});

it("knows the groups of a robot, and all of them once", () => {
  expect(naming.groupsOf("/robot1")).toEqual(["Hall 1", "forklifts"]);
  expect(naming.groupsOf("/gone")).toEqual([]);
  expect(naming.groups()).toEqual(["forklifts", "Hall 1"]);
});

it("finds a robot by its name, namespace and groups", () => {
  expect(["FORK", "robot1", "hall", " left "].map((text) => isFound(forklift, text))).toEqual(
    Array(4).fill(true),
  );
  expect(isFound(plain, "fork")).toBe(false);
  expect(isFound(root, "rob")).toBe(true);
});

it("knows whose action it is: of the longest namespace", () => {
  const owners = (names: Naming) =>
    ["/robot1/dock", "/robot1/arm/move", "/gone/dock", "/dock"].map((action) => names.ownerOf(action));
  expect(owners(new Naming([forklift]))).toEqual(["/robot1", "/robot1", null, null]);
  expect(owners(new Naming([forklift, root]))).toEqual(["/robot1", "/robot1", "/", "/"]);
});

it("knows the actions of a group", () => {
  const of = (action: string) => naming.isActionOf(action, "forklifts");
  expect(["/robot1/dock", "/robot1/arm/move", "/robot2/dock", "/dock"].map(of)).toEqual([
    true,
    true,
    false,
    false,
  ]);
  expect(naming.isActionOf("/gone/dock", "forklifts")).toBe(false);
});

it("knows whose action it is where that robot has a display name", () => {
  const site: Label = { name: "/", display_name: "Site", groups: [] };
  const names = new Naming([forklift, plain, site]);
  expect(
    ["/robot1/dock", "/robot1/arm/move", "/robot2/dock", "/gone/dock", "/dock"].map((action) =>
      names.ownerNameOf(action),
    ),
  ).toEqual(["Left forklift", "Left forklift", null, null, "Site"]);
});
