import { MantineProvider } from "@mantine/core";
import { render, screen } from "@testing-library/react";
import { describe, expect, it } from "vitest";
import type { JsonSchema } from "../src/api/jsonSchema";
import { MessageTree } from "../src/ui/MessageTree";
import { valueWords } from "../src/ui/messageWords";
import { battery } from "./events";

const SCHEMA: JsonSchema = {
  type: "object",
  properties: {
    current_battery_state: { $ref: "#/$defs/sensor_msgs.msg.BatteryState", description: "The latest one." },
  },
  $defs: {
    "builtin_interfaces.msg.Time": {
      type: "object",
      "x-ros-type": "builtin_interfaces/msg/Time",
      properties: { sec: { type: "integer" }, nanosec: { type: "integer" } },
    },
    "std_msgs.msg.Header": {
      type: "object",
      "x-ros-type": "std_msgs/msg/Header",
      properties: { stamp: { $ref: "#/$defs/builtin_interfaces.msg.Time" }, frame_id: { type: "string" } },
    },
    "sensor_msgs.msg.BatteryState": {
      type: "object",
      "x-ros-type": "sensor_msgs/msg/BatteryState",
      properties: {
        header: { $ref: "#/$defs/std_msgs.msg.Header" },
        voltage: { type: ["number", "null"], "x-unit": "V", description: "Voltage in Volts" },
        current: { type: ["number", "null"], "x-unit": "A" },
        power_supply_status: { type: "integer", "x-constants": { UNKNOWN: 0, NOT_CHARGING: 3 } },
        cell_voltage: { type: "array", items: { type: ["number", "null"] }, "x-unit": "V" },
      },
    },
  },
};

function tree(value: unknown, schema?: JsonSchema): HTMLElement {
  render(
    <MantineProvider env="test">
      <MessageTree value={value} schema={schema} label="Feedback" />
    </MantineProvider>,
  );
  return screen.getByTestId("message-tree");
}

const line = (name: string) => screen.getByText(name).closest("li")?.textContent;

describe("a message with its schema", () => {
  it("has units, names of constants, and NaN in words", () => {
    tree({ current_battery_state: { ...battery, cell_voltage: [3.9, null] } }, SCHEMA);
    expect(line("voltage")).toBe("voltage 2.16 V");
    expect(line("current")).toBe("current not measured");
    expect(line("power_supply_status")).toBe("power_supply_status NOT_CHARGING (3)");
    expect(line("cell_voltage")).toBe("cell_voltage 3.9, not measured V");
    expect(line("location")).toBe("location empty");
    expect(screen.getByText("voltage").title).toBe("Voltage in Volts");
    expect(screen.getByText("current_battery_state").title).toBe("The latest one.");
    expect(screen.getByText("sensor_msgs/BatteryState")).toBeDefined();
    expect(screen.getByRole("list", { name: "Feedback" })).toBeDefined();
  });

  it("folds the fields that say nothing into one line, and leaves one in its place that had a value", () => {
    const message = (voltage: number | null) => ({ ...battery, voltage });
    const shown = (voltage: number | null) => (
      <MantineProvider env="test">
        <MessageTree value={message(voltage)} label="Battery" />
      </MantineProvider>
    );
    const { rerender } = render(shown(2.16));
    const fold = () => screen.getByText(/^\d+ not measured or empty$/).closest("details");
    expect(fold()?.open).toBe(false);
    expect(fold()?.textContent).toContain("current not measured");
    expect(fold()?.textContent).not.toMatch(/[^_]voltage/);
    const count = fold()?.querySelector("summary")?.textContent;
    rerender(shown(null));
    expect(fold()?.querySelector("summary")?.textContent).toBe(count);
    expect(fold()?.textContent).not.toMatch(/[^_]voltage/);
  });

  it("unfolds what is asked for, and no more", () => {
    tree({ current_battery_state: battery }, SCHEMA);
    expect(screen.getByText("current_battery_state").closest("details")?.open).toBe(true);
    expect(screen.getByText("header").closest("details")?.open).toBe(false);
  });

  it("tells times as times, and those that are not set as such", () => {
    const stamp = { sec: 1_795_231_960, nanosec: 500_000_000 };
    tree({ current_battery_state: { ...battery, header: { stamp, frame_id: "" } } }, SCHEMA);
    expect(screen.getByText("stamp").closest("li")?.querySelector("time")?.dateTime).toBe(
      "2026-11-21T03:32:40.500Z",
    );
  });

  it("says that a time is not set", () => {
    tree({ current_battery_state: battery }, SCHEMA);
    expect(line("stamp")).toBe("stamp not set");
  });
});

describe("a message without a schema", () => {
  it("is told as it is", () => {
    tree({ order: 10, list: [0, 1, 1], flags: [true], when: { sec: 0, nanosec: 0 }, none: {} });
    expect(line("order")).toBe("order 10");
    expect(line("list")).toBe("list 0, 1, 1");
    expect(line("flags")).toBe("flags true");
    expect(line("sec")).toBe("sec 0");
    expect(screen.getByText("has no fields")).toBeDefined();
  });

  it("has the first items of what is long", () => {
    tree({ numbers: Array.from({ length: 100 }, (_, index) => index), points: Array(100).fill({ x: 1 }) });
    expect(line("numbers")).toMatch(/… and 40 more$/);
    expect(screen.getAllByText("x")).toHaveLength(60);
    expect(screen.getByText("… and 40 more", { selector: "li" })).toBeDefined();
  });
});

describe("a message that changes", () => {
  const message = (value: unknown) => (
    <MantineProvider env="test">
      <MessageTree value={value} label="Feedback" />
    </MantineProvider>
  );

  it("keeps the decimals of its numbers: they do not jitter", () => {
    const { rerender } = render(message({ voltage: 9, cells: [3, 3.25] }));
    expect([line("voltage"), line("cells")]).toEqual(["voltage 9", "cells 3.00, 3.25"]);
    rerender(message({ voltage: -8.95, cells: [3.5, 3] }));
    rerender(message({ voltage: 9, cells: [3, 3] }));
    expect([line("voltage"), line("cells")]).toEqual(["voltage 9.00", "cells 3.00, 3.00"]);
  });

  it("keeps what is folded, whatever comes", () => {
    const { rerender } = render(message({ pose: { points: [{ x: 1 }] } }));
    rerender(message({ pose: { points: Array(20).fill({ x: 1 }) } }));
    expect(screen.getByText("points").closest("details")?.open).toBe(true);
  });
});

describe("what is unfolded", () => {
  const opened = (name: string) => screen.getByText(name).closest("details")?.open;
  const vector = { x: 0.5, y: 0, z: 0 };

  it("is what is short, in any level, but for headers", () => {
    const pose = { position: vector, orientation: { ...vector, w: 1 } };
    const long = Object.fromEntries(Array.from({ length: 9 }, (_, index) => [`n${index}`, index]));
    const header = { stamp: { sec: 0, nanosec: 0 }, frame_id: "odom" };
    tree({ outer: { header, pose: { pose, covariance: Array(36).fill(0) }, long } });
    expect(["outer", "header", "position", "orientation", "long"].map(opened)).toEqual([
      true,
      false,
      true,
      true,
      false,
    ]);
  });

  it("is not a row of equal values: they are counted", () => {
    tree({ covariance: Array(36).fill(0), diagonal: [0.1, 0, 0, 0, 0, 0, 0.1], none: Array(5).fill(null) });
    expect(line("covariance")).toBe("covariance 36 × 0");
    expect(line("diagonal")).toBe("diagonal 0.1, 5 × 0.0, 0.1");
    expect(line("none")).toBe("none 5 × not measured");
  });
});

it("a value alone is told in words", () => {
  expect(valueWords(null)).toBe("not measured");
  expect(valueWords("")).toBe("empty");
  expect(valueWords("9007199254740993")).toBe("9007199254740993");
  expect(tree(3).textContent).toBe("3");
});
