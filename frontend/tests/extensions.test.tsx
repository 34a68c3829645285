import { screen } from "@testing-library/react";
import { describe, expect, it } from "vitest";
import { type Places, pagesOf, partsAt } from "../src/extension/extension";
import * as listed from "../src/extensions";
import { EXTENSIONS, fakeGateway, renderPage } from "./page";

describe("the list of extensions", () => {
  it("names each as its folder", () => {
    expect(EXTENSIONS.map(({ name }) => name)).toEqual(Object.keys(listed));
    const folders = Object.keys(import.meta.glob("../src/extensions/*/extension.tsx"));
    expect(folders.map((path) => path.split("/").at(-2)).sort()).toEqual(Object.keys(listed).sort());
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
