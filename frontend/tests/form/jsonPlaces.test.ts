import { describe, expect, it } from "vitest";
import { placeErrors } from "../../src/actions/jsonPlaces";

/** What is marked for an error at a path. */
function marked(text: string, path: string): string | undefined {
  return placeErrors(text, [{ path, detail: "wrong" }]).map(({ from, to }) => text.slice(from, to))[0];
}

const POSE = `{
  "pose": {"x": 1, "c": [0, [], {"d": null}]},
  "pose": {"x": 2, "c": [7, [], {"d": null}]}
}`;

describe("an error in JSON is marked", () => {
  it.each([
    ["pose.x", '"x": 2'],
    ["pose.c.0", "7"],
    ["pose.c.1", "[]"],
    ["pose.c.2.d", '"d": null'],
  ])("at its field, %s", (path, expected) => expect(marked(POSE, path)).toBe(expected));

  it.each([
    ["pose.missing", POSE, '"pose": {"x": 2, "c": [7, [], {"d": null}]}'],
    ["pose.x.y", POSE, '"x": 2'],
    ["other", POSE, "{"],
    ["", "[1]", "[1]"],
  ])("at the message where the field %s would be, on one line", (path, text, expected) =>
    expect(marked(text, path)).toBe(expected),
  );

  it.each([
    ['{"a": b}', 6],
    ['{"order": 10', 12],
    ['{"a" 1}', 5],
    ["{'a': 1}", 1],
    ["{} {}", 3],
    ['{"a": "\\q"}', 6],
    ['{"a": NaN}', 6],
    ["", 0],
  ])("where the text stops being JSON: %s", (text, from) =>
    expect(placeErrors(text, [{ path: "", detail: "this is not JSON" }])).toMatchObject([
      { from, message: "this is not JSON" },
    ]),
  );
});
