import { expect, it } from "vitest";
import { Labels } from "../src/scene/labels";

const SIZE = { width: 40, height: 12 };

it("no label lies on another one, and none is left out that has room", () => {
  const labels = new Labels();
  const places = Array.from({ length: 300 }, (_, index) => ({
    x: (index * 37) % 401,
    y: (index * 53) % 211,
  }));
  const [shown, left]: [typeof places, typeof places] = [[], []];
  for (const place of places) (labels.take(place, SIZE) ? shown : left).push(place);
  const touch = (one: (typeof places)[number], other: typeof one) =>
    Math.abs(one.x - other.x) < SIZE.width && Math.abs(one.y - other.y) < SIZE.height;
  expect(shown.some((one) => shown.some((other) => other !== one && touch(one, other)))).toBe(false);
  expect(left.every((one) => shown.some((other) => touch(one, other)))).toBe(true);
  expect(shown.length).toBeGreaterThan(50);
  expect(left.length).toBeGreaterThan(50);
});
