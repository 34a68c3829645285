// @vitest-environment jsdom

import { expect, it, vi } from "vitest";
import { ALL_ROBOTS } from "../src/fleet/robotChoice";
import { preferences, setPreferences } from "../src/notifications/preferences";

const QUIET = { desktop: false, sound: false, warnings: true, robots: ALL_ROBOTS };

it("a browser takes what is stored as far as it can be read", async () => {
  setPreferences({ sound: true, robots: { all: false, names: ["/a"], groups: [] } });
  const read = async (text: string) => {
    localStorage.setItem("dock-gateway-announcements", text);
    vi.resetModules();
    return (await import("../src/notifications/preferences")).preferences();
  };
  expect(await read(localStorage.getItem("dock-gateway-announcements") ?? "")).toEqual(preferences());
  for (const damaged of ["", "[", "null", "7", '{"sound":"yes","robots":[]}'])
    expect(await read(damaged)).toEqual(QUIET);
  expect((await read('{"robots":{"all":false,"names":[1,"/a"]}}')).robots).toEqual({
    all: false,
    names: ["/a"],
    groups: [],
  });
});
