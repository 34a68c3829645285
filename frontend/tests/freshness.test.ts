import { expect, it } from "vitest";
import { freshnessOf } from "../src/store/context";

it.each([
  ["live", true, 999],
  ["live", true, 1000],
  ["stale", true, 1001],
  ["none", true, null],
  ["offline", false, 0],
  ["offline", false, null],
] as const)("a source is %s", (freshness, connected, age) => {
  expect(freshnessOf(connected, age, 1000)).toBe(freshness);
});
