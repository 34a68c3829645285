import { afterAll, afterEach, beforeEach, vi } from "vitest";
import { START } from "./events";

// The page shows the day of a time unless it is today, and a battery is stale after seconds. So each test begins at the
// time of the test events (./events) instead of now, however long the imports took, and the clock runs on from there.
const RealDate = Date;
let shift = START - RealDate.now();
beforeEach(() => {
  shift = START - RealDate.now();
});
globalThis.Date = class extends RealDate {
  constructor(...parts: [] | [string]) {
    if (parts.length > 0) super(...(parts as [string]));
    else super(RealDate.now() + shift);
  }
  static override now() {
    return RealDate.now() + shift;
  }
} as DateConstructor;
Object.defineProperty(performance, "timeOrigin", {
  configurable: true,
  get: () => Date.now() - performance.now(),
});

// What a store is about to show would be shown after the last test of a file, when there is no page any more.
const realTimeout = globalThis.setTimeout;
const timers = new Set<ReturnType<typeof setTimeout>>();
globalThis.setTimeout = Object.assign((...parts: Parameters<typeof setTimeout>) => {
  const timer = realTimeout(...parts);
  timers.add(timer);
  return timer;
}, realTimeout);
afterAll(() => {
  for (const timer of timers) clearTimeout(timer);
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});
