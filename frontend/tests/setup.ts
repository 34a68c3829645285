import { notifications } from "@mantine/notifications";
import { cleanup, configure } from "@testing-library/react";
import type { ComponentType } from "react";
import { afterEach, beforeEach, vi } from "vitest";
import { ANYBODY, session } from "../src/api/session";
import { ALL_ROBOTS } from "../src/fleet/robotChoice";
import { setPreferences } from "../src/notifications/preferences";
import { setZone } from "../src/ui/zone";
import { streams } from "./streams";

// On a busy machine seconds are not much.
configure({ asyncUtilTimeout: 60_000 });

// The files share their modules: each begins as on a page that was just opened.
session.set(ANYBODY);
setZone("local");
setPreferences({ desktop: false, sound: false, warnings: true, robots: ALL_ROBOTS });
notifications.clean();
notifications.cleanQueue();
localStorage.clear();

// No gateway answers here, and parts of a page wait for one. What a file's tests have shown before is there at once.
vi.mock("../src/ui/lazyPart", async () => {
  const { createElement, lazy, useState } = await import("react");
  const lazyPart = (load: () => Promise<{ default: ComponentType<object> }>) => {
    let loaded: ComponentType<object> | null = null;
    const first = lazy(async () => {
      const part = await load();
      loaded = part.default;
      return part;
    });
    return function Part(props: object) {
      const [part] = useState(() => ({ component: loaded ?? first }));
      return createElement(part.component, props);
    };
  };
  return { lazyPart };
});

// Every file has these: a module that another file has loaded before would not see one that only a single file mocks.
vi.mock("../src/stream/stream", async (original) => ({
  ...(await original<object>()),
  openStream: (await import("./streams")).openStream,
}));
vi.mock("../src/ui/PlotStack", () => import("./plots"));

// The page that a failing query prints is long to write, and written for each try of one that waits.
process.env.DEBUG_PRINT_LIMIT ??= "0";

// jsdom matches every rule of the browser's own style sheet for every element that a query looks at, which is a quarter of
// the time. The pages' style sheets are not loaded: what an element looks like is in its tag and its attributes.
const UNSEEN = new Set("HEAD LINK META SCRIPT STYLE TEMPLATE TITLE".split(" "));
const INLINE = new Set("A ABBR B BR CODE EM I IMG KBD LABEL SPAN STRONG SUB SUP SVG TIME WBR".split(" "));
function displayOf(element: Element): string {
  const folder = element.parentElement?.tagName === "DETAILS" ? element.parentElement : null;
  const folded = folder !== null && element.tagName !== "SUMMARY" && !folder.hasAttribute("open");
  if (folded || element.hasAttribute("hidden") || UNSEEN.has(element.tagName)) return "none";
  return INLINE.has(element.tagName.toUpperCase()) ? "inline" : "block";
}
window.getComputedStyle = (element: Element) => {
  const { style } = element as HTMLElement;
  const read = (name: string): string => {
    const own = style?.getPropertyValue(name) ?? "";
    if (name === "display") return own || displayOf(element);
    if (name !== "visibility") return own;
    return element.closest<HTMLElement>("[style*=visibility]")?.style.visibility || "visible";
  };
  const get = (_: object, name: string) =>
    name === "getPropertyValue" ? read : read(name.replace(/[A-Z]/g, "-$&").toLowerCase());
  return new Proxy({}, { get }) as CSSStyleDeclaration;
};

// No gateway is found, at once: how long a machine looks for its name differs.
globalThis.fetch = () => Promise.reject(new TypeError("fetch failed"));

// What jsdom lacks and the page's libraries ask for: a wide window, in which nothing moves.
window.matchMedia ??= (query: string) =>
  ({
    matches: query.includes("reduce") || query.includes("min-width"),
    media: query,
    addEventListener: () => {},
    removeEventListener: () => {},
    addListener: () => {},
    removeListener: () => {},
  }) as unknown as MediaQueryList;
window.ResizeObserver ??= class {
  observe() {}
  unobserve() {}
  disconnect() {}
};
window.IntersectionObserver ??= class {
  observe() {}
  disconnect() {}
} as unknown as typeof IntersectionObserver;
Element.prototype.scrollIntoView ??= () => {};

// React reports mistakes, such as a <div> in a <p>, on the console only. That updates come from timers and not from
// act() is how the page works.
let mistakes: string[] = [];
beforeEach(() => {
  streams.length = 0;
  mistakes = [];
  vi.spyOn(console, "error").mockImplementation((...parts: unknown[]) => {
    const text = parts.map(String).join(" ");
    if (!text.includes("act(")) mistakes.push(text);
  });
});

afterEach(() => {
  cleanup();
  if (mistakes.length > 0) throw new Error(`React complained:\n${mistakes.join("\n")}`);
});
