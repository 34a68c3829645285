import { describe, expect, it } from "vitest";
import { initialValues, readMessage } from "../../src/actions/form/read";
import {
  type Field,
  type MessageShape,
  type Path,
  type Shape,
  shapeOf,
  type Value,
  type Values,
  withValue,
} from "../../src/actions/form/shapes";
import { lengthWords, writeMessage } from "../../src/actions/form/write";
import type { Json, JsonObject, JsonSchema } from "../../src/api/jsonSchema";
import { Random, randomMessage, takes } from "./random";
import schemas from "./schemas.json";

const REAL = Object.entries(schemas as unknown as Record<string, JsonSchema>).map(
  ([name, schema]) => [name, schema, shapeOf(schema)] as const,
);
const RUNS = 25;

function real(name: string): MessageShape {
  const found = REAL.find(([each]) => each === name);
  if (found === undefined) throw new Error(`no schema of ${name}`);
  return found[2];
}

function field(shape: MessageShape, ...names: string[]): Field {
  const [name, ...rest] = names;
  const found = shape.fields.find((each) => each.name === name);
  if (found === undefined) throw new Error(`no field ${name}`);
  if (rest.length === 0) return found;
  if (found.shape.kind !== "message") throw new Error(`${name} is no message`);
  return field(found.shape, ...rest);
}

const dock = real("action_tutorials_interfaces/action/ConnectToChargingDock");
const battery = field(dock, "desired_battery_state").shape as MessageShape;
const fibonacci = real("action_tutorials_interfaces/action/Fibonacci");
const defaults = real("test_msgs/msg/Defaults");
const grid = real("nav_msgs/msg/OccupancyGrid");
const pose = real("geometry_msgs/msg/PoseWithCovarianceStamped");
const image = real("sensor_msgs/msg/Image");
const arrays = real("test_msgs/msg/Arrays");
const bounded = real("test_msgs/msg/BoundedSequences");

/** What is sent, and what is said, when one field holds this. */
function type(shape: MessageShape, path: Path, value: Value) {
  return writeMessage(shape, withValue(initialValues(shape), path, value));
}

describe("a form out of a JSON Schema", () => {
  it("knows types, constants, units, descriptions and defaults", () => {
    expect(field(battery, "voltage")).toMatchObject({
      unit: "V",
      description: "Voltage in Volts (Mandatory)",
      initial: null,
      shape: { kind: "float", unset: true },
    });
    const status = field(battery, "power_supply_status").shape;
    expect(status).toMatchObject({ kind: "integer", low: 0n, high: 255n, wide: false });
    expect(status.kind === "integer" && status.choices.map(({ name, value }) => `${name} ${value}`)).toEqual([
      "UNKNOWN 0",
      "CHARGING 1",
      "DISCHARGING 2",
      "NOT_CHARGING 3",
      "FULL 4",
    ]);
    expect(field(fibonacci, "order").shape).toMatchObject({ low: -(2n ** 31n), high: 2n ** 31n - 1n });
    expect(field(battery, "cell_voltage").shape).toMatchObject({ kind: "numbers", low: 0, high: 10_000 });
    expect(field(pose, "pose", "covariance").shape).toMatchObject({ kind: "numbers", low: 36, high: 36 });
    expect(field(image, "data").shape).toMatchObject({ kind: "bytes", low: 0, high: 1_000_000 });
    expect(field(arrays, "string_values").shape).toMatchObject({ kind: "list", low: 3, high: 3 });
    expect(field(arrays, "uint64_values").shape).toMatchObject({
      item: { wide: true, high: 2n ** 64n - 1n },
    });
  });

  it("has the defaults of the definition in place, and what is unmeasured empty", () => {
    const values = initialValues(dock).desired_battery_state as Values;
    expect(values.voltage).toBe("");
    expect(values.power_supply_status).toBe("0");
    expect(values.present).toBe(false);
    expect(initialValues(defaults)).toMatchObject({
      bool_value: true,
      float64_value: "1.125",
      int16_value: "-1000",
    });
    expect((initialValues(arrays).defaults_values as Values[])[2]).toEqual(initialValues(defaults));
  });
});

describe("what is sent", () => {
  it("is only what is not as it would be anyway", () => {
    expect(type(fibonacci, ["order"], "10")).toEqual({ message: { order: 10 }, errors: [] });
    expect(type(fibonacci, ["order"], "0").message).toEqual({});
    expect(type(dock, ["desired_battery_state", "power_supply_status"], "1").message).toEqual({
      desired_battery_state: { power_supply_status: 1 },
    });
    expect(type(arrays, ["defaults_values", 1, "bool_value"], false).message).toEqual({
      defaults_values: [{}, { bool_value: false }, {}],
    });
  });

  it.each<[MessageShape, Path, Value, Json]>([
    [battery, ["voltage"], " 2.16 ", 2.16],
    [battery, ["voltage"], "−1e-3", -0.001],
    [battery, ["cell_voltage"], "[3.9, nan, -; 4]", [3.9, null, null, 4]],
    [defaults, ["float64_value"], "NaN", null],
    [defaults, ["int64_value"], "9223372036854775807", "9223372036854775807"],
    [defaults, ["int64_value"], "+7", 7],
    [grid, ["data"], "0 -1\n100", [0, -1, 100]],
    [image, ["data"], { encoding: "numbers", text: "1, 255" }, [1, 255]],
    [image, ["data"], { encoding: "base64", text: "AP8 =\n" }, "AP8="],
    [arrays, ["string_values", 2], "c", ["", "", "c"]],
  ])("%# is a message out of text", (shape, path, value, json) => {
    const { message, errors } = type(shape, path, value);
    expect(errors).toEqual([]);
    expect(message[path[0] as string]).toEqual(json);
  });

  it("leaves out an array whose default the schema does not tell", () => {
    expect(type(pose, ["pose", "covariance"], " ")).toEqual({ message: {}, errors: [] });
  });
});

describe("what is wrong is said at its field", () => {
  it.each<[MessageShape, Path, Value, string, RegExp]>([
    [fibonacci, ["order"], "", "order", /a whole number from −2147483648 to 2147483647/],
    [fibonacci, ["order"], "1.0", "order", /a whole number/],
    [fibonacci, ["order"], "2147483648", "order", /a whole number/],
    [battery, ["voltage"], "2,16", "voltage", /a number, or nothing for not measured/],
    [battery, ["voltage"], "1e39", "voltage", /3\.4e38/],
    [defaults, ["float64_value"], "", "float64_value", /or NaN for not measured/],
    [defaults, ["float64_value"], "1e999", "float64_value", /float64/],
    [defaults, ["uint64_value"], "-1", "uint64_value", /from 0 to 18446744073709551615/],
    [battery, ["cell_voltage"], "3.9, volts", "cell_voltage.1", /number 2, “volts”: expected a number/],
    [battery, ["location"], "a\0b", "location", /NUL/],
    [pose, ["pose", "covariance"], "1 2 3", "pose.covariance", /expected 36 numbers, got 3/],
    [arrays, ["int32_values"], "", "int32_values", /expected 3 numbers, got 0/],
    [bounded, ["string_values"], ["a", "b", "c", "d"], "string_values", /at most 3 items, got 4/],
    [image, ["data"], { encoding: "base64", text: "AP8" }, "data", /padding/],
    [image, ["data"], { encoding: "numbers", text: "256" }, "data.0", /from 0 to 255/],
  ])("%#", (shape, path, value, where, words) => {
    const { errors } = type(shape, path, value);
    expect(errors.map((error) => error.path)).toEqual([where]);
    expect(errors[0]?.detail).toMatch(words);
  });

  it("counts characters as ROS does", () => {
    const short: MessageShape = {
      kind: "message",
      type: "t",
      description: null,
      fields: [
        { name: "text", shape: { kind: "text", high: 2 }, description: null, unit: null, initial: "" },
      ],
    };
    expect(type(short, ["text"], "🤖🤖").errors).toEqual([]);
    expect(type(short, ["text"], "🤖🤖🤖").errors[0]?.detail).toBe("expected at most 2 characters, got 3");
  });

  it("has words for lengths", () => {
    expect(lengthWords({ low: 9, high: 9 }, "number")).toBe("9 numbers");
    expect(lengthWords({ low: 0, high: 1 }, "item")).toBe("at most 1 item");
    expect(lengthWords({ low: 1, high: Number.POSITIVE_INFINITY }, "byte")).toBe("at least 1 byte");
    expect(lengthWords({ low: 0, high: Number.POSITIVE_INFINITY }, "byte")).toBe("");
  });
});

describe("JSON in the form", () => {
  it("may have constants by name, short or in full", () => {
    for (const name of ["CHARGING", "charging", "POWER_SUPPLY_STATUS_CHARGING"]) {
      const { values, errors } = readMessage(battery, { power_supply_status: name });
      expect(errors).toEqual([]);
      expect(values.power_supply_status).toBe("1");
    }
  });

  it.each<[MessageShape, Json, string, RegExp]>([
    [battery, { volts: 1 }, "volts", /expected one of header, voltage/],
    [battery, { voltage: "12" }, "voltage", /a number or null, got a string/],
    [battery, { header: null }, "header", /an object, got null/],
    [battery, { present: 1 }, "present", /true or false, got 1/],
    [battery, { power_supply_status: "GOOD" }, "power_supply_status", /name of a constant/],
    [battery, { cell_voltage: [1, true] }, "cell_voltage.1", /a number or null, got true/],
    [defaults, { int64_value: 2 ** 60 }, "int64_value", /JSON rounds/],
    [arrays, { string_values: { 0: "a" } }, "string_values", /an array, got an object/],
    [fibonacci, [], "", /an object, got an array/],
  ])("%# cannot be shown", (shape, json, where, words) => {
    const { errors } = readMessage(shape, json);
    expect(errors.map((error) => error.path)).toEqual([where]);
    expect(errors[0]?.detail).toMatch(words);
  });

  it("is shown where it is only too much, with what is wrong", () => {
    const { values, errors } = readMessage(fibonacci, { order: 1e12 });
    expect(errors).toEqual([]);
    expect(writeMessage(fibonacci, values).errors[0]?.path).toBe("order");
  });
});

describe.each(REAL)("%s", (_name, schema, shape) => {
  it("begins with nothing to send and nothing wrong", () => {
    expect(writeMessage(shape, initialValues(shape))).toEqual({ message: {}, errors: [] });
  });

  it("keeps what a message means, through the form and back", () => {
    const random = new Random(1);
    for (let run = 0; run < RUNS; run += 1) {
      const message = randomMessage(shape, random);
      expect(takes(schema, message, schema)).toBe(true);
      const read = readMessage(shape, message);
      const written = writeMessage(shape, read.values);
      expect({ message, errors: [...read.errors, ...written.errors] }).toEqual({ message, errors: [] });
      expect(takes(schema, written.message, schema)).toBe(true);
      expect(complete(shape, written.message)).toEqual(complete(shape, message));
      expect(writeMessage(shape, readMessage(shape, written.message).values)).toEqual(written);
    }
  });

  it("sends what the schema takes, whatever is typed, or says where it is wrong", () => {
    const random = new Random(2);
    const junk = ["", " ", "-1", "1.5", "1e400", "0x10", "99999999999999999999999", "abc", "1, x", "\0", "∞"];
    for (let run = 0; run < RUNS; run += 1) {
      const values = readMessage(shape, randomMessage(shape, random)).values;
      const leaves = textsOf(shape, values, []);
      if (leaves.length === 0) return;
      const path = random.of(leaves);
      const { message, errors } = writeMessage(shape, withValue(values, path, random.of(junk)));
      expect(takes(schema, message, schema)).toBe(true);
      for (const error of errors) expect(`${error.path}.`).toContain(`${path.join(".")}.`);
    }
  });
});

/** Where texts are typed. */
function textsOf(shape: Shape, value: Value, path: Path): Path[] {
  if (shape.kind === "message") {
    return shape.fields.flatMap((each) =>
      textsOf(each.shape, (value as Values)[each.name] ?? "", [...path, each.name]),
    );
  }
  if (shape.kind === "list") {
    return (value as Value[]).flatMap((item, index) => textsOf(shape.item, item, [...path, index]));
  }
  return typeof value === "string" ? [path] : [];
}

/** A message with every field, so that two that mean the same are the same; without what nobody tells. */
function complete(shape: Shape, json: Json | undefined): Json | undefined {
  if (shape.kind === "message") {
    const given = (json ?? {}) as JsonObject;
    const fields = shape.fields.map((each) => [
      each.name,
      complete(each.shape, given[each.name] ?? (given[each.name] === null ? null : each.initial)),
    ]);
    return Object.fromEntries(fields);
  }
  if (shape.kind === "list" && json !== undefined) {
    return (json as Json[]).map((item) => complete(shape.item, item) as Json);
  }
  if (shape.kind === "bytes" && typeof json === "string") {
    return [...atob(json)].map((character) => character.charCodeAt(0));
  }
  if (shape.kind === "integer" && typeof json === "string") {
    return shape.choices.find((choice) => choice.name === json)?.value ?? json;
  }
  return json;
}
