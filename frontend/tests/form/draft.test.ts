import { describe, expect, it } from "vitest";
import { quoted, sendLine } from "../../src/actions/actions";
import {
  asForm,
  asJson,
  type Draft,
  errorsAt,
  errorsIn,
  newDraft,
  outgoing,
  spaced,
  withDefaults,
  withField,
  withText,
} from "../../src/actions/form/draft";
import { convertBytes, countBytes } from "../../src/actions/form/numbers";
import { shapeOf } from "../../src/actions/form/shapes";
import type { JsonSchema } from "../../src/api/jsonSchema";
import schemas from "./schemas.json";

const { "action_tutorials_interfaces/action/ConnectToChargingDock": dock } = schemas as unknown as Record<
  string,
  JsonSchema
>;
const shape = shapeOf(dock as JsonSchema);
const VOLTAGE = ["desired_battery_state", "voltage"];
const refused = { path: "desired_battery_state.voltage", detail: "expected less, got 7" };

function form(draft: Draft): Draft {
  const next = asForm(draft, shape);
  if (!("mode" in next)) throw new Error(JSON.stringify(next));
  return next;
}

describe("a draft", () => {
  it("begins with a message and becomes what is sent", () => {
    const draft = newDraft(shape, { desired_battery_state: { power_supply_status: "CHARGING" } });
    expect(outgoing(withField(draft, VOLTAGE, "12.5"), shape)).toMatchObject({
      body: '{"desired_battery_state": {"voltage": 12.5, "power_supply_status": 1}}',
      ready: true,
      errors: [],
    });
    expect(outgoing(withDefaults(draft, shape), shape).body).toBe("{}");
  });

  it("is not sent while something in it is wrong", () => {
    const out = outgoing(withField(newDraft(shape), VOLTAGE, "much"), shape);
    expect(out.ready).toBe(false);
    expect(out.errors.map(({ path }) => path)).toEqual(["desired_battery_state.voltage"]);
  });

  it("shows what the gateway refused until that is changed, and may be sent again all the same", () => {
    const draft = { ...withField(newDraft(shape), VOLTAGE, "7"), refused: [refused] };
    expect(outgoing(draft, shape)).toMatchObject({ ready: true, errors: [refused] });
    const elsewhere = withField(draft, ["desired_battery_state", "location"], "hall");
    expect(outgoing(elsewhere, shape).errors).toEqual([refused]);
    expect(outgoing(withField(elsewhere, VOLTAGE, "5"), shape).errors).toEqual([]);
  });

  it("is the same as JSON, and as a form again", () => {
    const json = asJson(withField(newDraft(shape), VOLTAGE, "5"), shape);
    expect(json.text).toBe('{\n  "desired_battery_state": {\n    "voltage": 5\n  }\n}');
    const edited = form(withText(json, '{"desired_battery_state": {"voltage": 6, "present": true}}'));
    expect(edited.values.desired_battery_state).toMatchObject({ voltage: "6", present: true });
  });

  it("keeps what is half typed where the JSON was only looked at", () => {
    const half = withField(newDraft(shape), VOLTAGE, "5.");
    expect(form(asJson(withField(half, VOLTAGE, "5 V"), shape)).values).toMatchObject({
      desired_battery_state: { voltage: "5 V" },
    });
  });

  it("sends JSON as it was typed", () => {
    const text = ' {"desired_battery_state":\n {"power_supply_status": "FULL"}} ';
    const out = outgoing(withText(asJson(newDraft(shape), shape), text), shape);
    expect(out).toMatchObject({ body: text.trim(), ready: true });
  });

  it.each([
    ["{", "", /this is not JSON/],
    ["[]", "", /expected an object, got an array/],
    ['{"desired_battery_state": {"volts": 1}}', "desired_battery_state.volts", /expected one of/],
    ['{"desired_battery_state": {"power_supply_status": 256}}', /status/, /from 0 to 255/],
  ])("says what is wrong with %s", (text, path, detail) => {
    const draft = withText(asJson(newDraft(shape), shape), text);
    const { ready, errors } = outgoing(draft, shape);
    expect(ready).toBe(false);
    expect(errors).toHaveLength(1);
    expect(errors[0]?.path).toMatch(path);
    expect(errors[0]?.detail).toMatch(detail);
  });

  it("stays JSON where a form cannot show it", () => {
    const draft = withText(asJson(newDraft(shape), shape), '{"nope": 1}');
    expect(asForm(draft, shape)).toMatchObject([{ path: "nope" }]);
  });
});

describe("errors by place", () => {
  const errors = [
    { path: "pose", detail: "a" },
    { path: "pose.x", detail: "b" },
    { path: "poses", detail: "c" },
  ];

  it("are at it, or within it", () => {
    expect(errorsAt(errors, "pose").map(({ detail }) => detail)).toEqual(["a"]);
    expect(errorsIn(errors, "pose").map(({ detail }) => detail)).toEqual(["a", "b"]);
    expect(errorsIn(errors, "")).toHaveLength(3);
  });
});

describe("a command line", () => {
  it("is of one action, whatever its namespace", () => {
    expect(sendLine("http://robot:8000", "/robot1/fibonacci", '{"order": 10}')).toBe(
      `curl -sX POST http://robot:8000/actions/robot1/fibonacci/goals -H 'Content-Type: application/json' -d '{"order": 10}'`,
    );
  });

  it("holds quotes that a shell leaves alone", () => {
    expect(quoted("it's $HOME `x`")).toBe("'it'\\''s $HOME `x`'");
  });
});

describe("bytes", () => {
  it("are the same both ways, and left alone where they are none", () => {
    const numbers = { encoding: "numbers", text: "0, 255, 7" } as const;
    const base64 = convertBytes(numbers, "base64");
    expect(base64).toEqual({ encoding: "base64", text: "AP8H" });
    expect(convertBytes(base64, "numbers")).toEqual(numbers);
    expect(countBytes(base64)).toBe(3);
    expect(convertBytes({ encoding: "numbers", text: "256" }, "base64").text).toBe("256");
    expect(countBytes({ encoding: "base64", text: "A" })).toBeNull();
  });
});

describe("JSON on one line", () => {
  it("has spaces where people put them, and texts as they are", () => {
    const json = { a: [1, { b: "x,\n [y] : {z}" }], c: {}, d: [] };
    expect(spaced(json)).toBe('{"a": [1, {"b": "x,\\n [y] : {z}"}], "c": {}, "d": []}');
    expect(JSON.parse(spaced(json))).toEqual(json);
  });
});
