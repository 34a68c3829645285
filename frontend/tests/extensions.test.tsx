import { screen } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import { Parts } from "../src/extension/context";
import { type Places, pagesOf, partsAt, startAll } from "../src/extension/extension";
import * as listed from "../src/extensions";
import { goal } from "./events";
import { EXTENSIONS, fakeGateway, renderPage, renderWithin, robotServices } from "./page";

const DOCKED = goal("docked");

describe("the list of extensions", () => {
  it("names each as its folder", () => {
    expect(EXTENSIONS.map(({ name }) => name)).toEqual(Object.keys(listed));
    const folders = Object.keys(import.meta.glob("../src/extensions/*/extension.tsx"));
    expect(folders.map((path) => path.split("/").at(-2)).sort()).toEqual(Object.keys(listed).sort());
  });
});

describe("an extension that throws", () => {
  const fails = () => {
    throw new Error("out of order");
  };
  it("keeps no other from its start", () => {
    const report = vi.fn();
    vi.stubGlobal("reportError", report);
    const start = vi.fn();
    startAll([
      { name: "broken", start: fails },
      { name: "whole", start },
    ]);
    expect(start).toHaveBeenCalledOnce();
    expect(report).toHaveBeenCalledOnce();
    vi.unstubAllGlobals();
  });

  it.each([
    ["listedGoal", <Parts key="" at="listedGoal" goal={DOCKED} quiet />, null],
    ["replay", <Parts key="" at="replay" goal={DOCKED} onLayer={() => {}} quiet />, null],
    ["robotHead", <Parts key="" at="robotHead" robot="/" />, "The extension broken cannot be shown"],
  ] as const)("takes no other part of %s with it", (place, parts, said) => {
    vi.spyOn(console, "error").mockImplementation(() => {});
    renderWithin(robotServices(fakeGateway()).fleet, parts, "/", [
      { name: "broken", parts: { [place]: fails } },
      { name: "whole", parts: { [place]: () => "still here" } },
    ]);
    expect(screen.getByText("still here")).toBeTruthy();
    expect(screen.queryByText(/cannot be shown/)?.textContent ?? null).toBe(said);
  });
});

describe.each(EXTENSIONS.map((extension) => [extension.name, extension] as const))(
  "without %s",
  (_, extension) => {
    const rest = EXTENSIONS.filter((each) => each !== extension);

    it("the list has no page and no part of it", () => {
      for (const page of extension.pages ?? []) expect(pagesOf(rest)).not.toContain(page);
      for (const place of Object.keys(extension.parts ?? {}) as (keyof Places)[])
        expect(partsAt(rest, place).map(([name]) => name)).not.toContain(extension.name);
    });

    const paths = (extension.pages ?? []).flatMap(({ path, at }) => (at === "sites" ? [] : [path]));

    it.each(paths)("there is no page %s", async (path) => {
      renderPage(fakeGateway(), {}, path, undefined, rest);
      expect(await screen.findByText("There is no such page")).toBeTruthy();
    });
  },
);
