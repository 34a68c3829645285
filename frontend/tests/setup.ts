import { cleanup, configure } from "@testing-library/react";
import type { ComponentType } from "react";
import { afterEach, beforeEach, vi } from "vitest";

// On a busy machine seconds are not much.
configure({ asyncUtilTimeout: 20_000 });

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

// What jsdom lacks and the page's libraries ask for.
window.matchMedia ??= (query: string) =>
  ({
    matches: query.includes("reduce"),
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
