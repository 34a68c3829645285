import type { BatteryHistory, BatteryState } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import type { GraphTopic } from "../src/api/graph";
import { PRESETS, sameForm, toMessage } from "../src/battery/form";
import { whoPublishes } from "../src/battery/PublisherCard";
import { describe as describeQuantity, fromHistory, gapLimit, join } from "../src/battery/points";
import { formatSpread, formatValue, marks, rangeOf } from "../src/battery/quantities";
import {
  formatCells,
  formatPercentage,
  formatQuantity,
  implausibleWords,
  isLow,
  statusWords,
  summarize,
} from "../src/battery/words";
import { BatterySeries, believed, noPoints, WINDOW_S } from "../src/store/batterySeries";
import { at, battery, batteryDocument } from "./events";

const [low, charging] = PRESETS;

describe("the editor", () => {
  it("publishes the tutorial's messages with its presets", () => {
    expect(toMessage(low.form)).toEqual({ voltage: 2.16, percentage: 0.24, power_supply_status: 3 });
    expect(toMessage(charging.form)).toEqual({ voltage: 2.16, percentage: 0.24, power_supply_status: 1 });
    expect(sameForm(low.form, charging.form)).toBe(false);
  });

  it("leaves out what is not measured, and sends everything else", () => {
    expect(
      toMessage({
        ...low.form,
        percent: 7,
        voltage: "",
        current: -1.5,
        temperature: 0,
        power_supply_health: 1,
        power_supply_technology: 2,
        present: true,
        cell_voltage: [3.9, "", "3.8"],
        location: "slot 1",
        frame_id: "base_link",
      }),
    ).toEqual({
      percentage: 0.07,
      current: -1.5,
      temperature: 0,
      power_supply_status: 3,
      power_supply_health: 1,
      power_supply_technology: 2,
      present: true,
      cell_voltage: [3.9, null, 3.8],
      location: "slot 1",
      header: { frame_id: "base_link" },
    });
  });

  it("refuses what is no number", () => {
    expect(toMessage({ ...low.form, cell_temperature: ["-"] })).toBeNull();
    expect(toMessage({ ...low.form, voltage: "-." })).toBeNull();
    expect(toMessage({ ...low.form, percent: "1e999" })).toBeNull();
  });
});

describe("who publishes a battery", () => {
  const qos = {} as GraphTopic["publishers"][number]["qos"];
  const topic = (...nodes: (string | null)[]): GraphTopic => ({
    name: "/battery_status",
    types: [],
    publishers: nodes.map((node) => ({ node, qos })),
    subscribers: [],
    hidden: false,
  });

  it("is told by name, this gateway and the simulator apart", () => {
    const seen = topic("/dock_gateway", "/dock_simulator", "/driver", "/driver", "/_ros2cli_4711", null);
    expect(whoPublishes(seen, "/dock_gateway", true)).toEqual({
      topic: "/battery_status",
      others: ["/driver", "a DDS program that is no ROS node", "ros2 topic pub"],
      simulators: ["/dock_simulator"],
    });
  });

  it("is nobody else where the gateway is alone", () => {
    expect(whoPublishes(topic("/dock_gateway"), "/dock_gateway", false).others).toEqual([]);
  });

  it("takes no simulator's word where the robot is not simulated", () => {
    expect(whoPublishes(topic("/dock_simulator"), "/dock_gateway", false).others).toEqual([
      "/dock_simulator",
    ]);
  });
});

const state = (percentage: number | null, voltage: number | null): BatteryState => ({
  ...battery,
  percentage,
  voltage,
});

describe("BatterySeries", () => {
  it("holds what was measured over time, in the units of the plots", () => {
    const series = new BatterySeries();
    series.push(1000, state(0.24, 2.16));
    series.push(2000, { ...state(null, 2.2), current: -1.5, temperature: 31 });
    expect(series.points.times).toEqual([1, 2]);
    const { percentage, voltage, current, temperature } = series.points.bands;
    expect([percentage.mean, voltage.mean]).toEqual([
      [24, null],
      [2.16, 2.2],
    ]);
    expect([current.mean, temperature.mean]).toEqual([
      [null, -1.5],
      [null, 31],
    ]);
    expect(series.version).toBe(2);
  });

  it("is bounded, whatever the rate and however long it runs", () => {
    const series = new BatterySeries();
    for (let time = 0; time < 2 * WINDOW_S * 1000; time += 10) series.push(time, state(0.5, 12));
    expect(series.length).toBeLessThanOrEqual(WINDOW_S * 4 * 1.1 + 64);
    expect(series.points.times.at(-1)).toBeCloseTo(2 * WINDOW_S, 1);
    expect(series.points.bands.voltage.mean).toHaveLength(series.length);
    expect(series.points.bands.current.max).toHaveLength(series.length);
  });

  it("loses no value to messages that do not have it, and no extreme value", () => {
    for (const spacing of [10, 50, 100, 125, 240])
      for (const turn of [0, 1]) {
        const series = new BatterySeries();
        const [dip, steady, count] = [3, 12, 200];
        for (let index = 0; index < count; index += 1)
          series.push(
            index * spacing,
            state(index % 2 === turn ? 0.5 : null, index === 2 * (count >> 2) ? dip : steady),
          );
        const { percentage, voltage } = series.points.bands;
        const measured = percentage.mean.filter((value) => value !== null);
        expect(measured.length).toBeGreaterThanOrEqual(Math.floor(percentage.mean.length / 2));
        expect(Math.min(...voltage.min.map((value, index) => value ?? voltage.mean[index] ?? 99))).toBe(dip);
      }
  });

  it("leaves out what is older than the last", () => {
    const series = new BatterySeries();
    series.push(60_000, state(0.6, 12));
    series.push(30_000, state(0.1, 1));
    expect(series.points.times).toEqual([60]);
  });
});

const history = (times: number[], voltages: (number | null)[]): BatteryHistory => {
  const column = (values: (number | null)[]) => ({ mean: values, min: values, max: values });
  const nothing = column(times.map(() => null));
  return {
    robot: "/",
    since: at(0),
    until: at(300),
    resolution_s: 0.5,
    time: times.map((time) => new Date(time * 1000).toISOString()),
    voltage: column(voltages),
    percentage: column(times.map(() => 0.5)),
    current: nothing,
    temperature: nothing,
    power_supply_status: times.map(() => 3),
  };
};

describe("the past and what is heard live", () => {
  it("become one, each moment once", () => {
    const series = new BatterySeries();
    for (const time of [4, 5, 8]) series.push(time * 1000, state(0.5, 12));
    const past = fromHistory(history([1, 2, 3, 4, 5, 6, 7], [9, 9, 9, 9, 9, 9, 9]));
    const joined = join(past, series.points, 0.5);
    expect(joined.times).toEqual([1, 2, 3, 4, 5, 6, 7, 8]);
    expect(joined.bands.voltage.mean).toEqual([9, 9, 9, 12, 12, 9, 9, 12]);
    expect(joined.bands.percentage.mean[0]).toBe(50);
    expect(joined.bands.voltage.min).toEqual([9, 9, 9, null, null, 9, 9, null]);
  });

  it("have a hole where nothing was measured, and where nothing came for long", () => {
    const past = fromHistory(history([1, 2, 3, 4, 5, 6, 7, 27], [9, null, 9, 9, 9, 9, 9, 9]));
    const { times, bands } = join(past, noPoints(), 0.5);
    expect(times).toEqual([1, 2, 3, 4, 5, 6, 7, 17, 27]);
    expect(bands.voltage.mean).toEqual([9, null, 9, 9, 9, 9, 9, null, 9]);
    expect(bands.percentage.mean[7]).toBeNull();
  });

  it("know a pause from a battery that tells its state seldom", () => {
    const every = (spacing: number) => Array.from({ length: 10 }, (_, index) => index * spacing);
    expect(gapLimit(every(0.1))).toBe(5);
    expect(gapLimit(every(60))).toBe(180);
    expect(gapLimit([0, 60])).toBe(15);
  });
});

describe("words", () => {
  it("say each cell, and alike ones once", () => {
    expect(formatCells([3.9, null, 4.0012], "V")).toBe("3.90, –, 4.00 V");
    expect(formatCells([25.001, 25.002, 25.003], "°C")).toBe("3 × 25.0 °C");
    expect(formatCells([1, 1], "V")).toBe("1.00, 1.00 V");
  });

  it("say what the numbers mean", () => {
    expect(statusWords(3)).toBe("Not charging");
    expect(statusWords(9)).toBe("Status 9");
    expect(formatPercentage(0.24)).toBe("24 %");
    expect([0.1996, 0.2, 0.29, Math.fround(0.29), 0.9999, 1].map(formatPercentage)).toEqual([
      ...["19 %", "20 %", "29 %", "29 %", "99 %", "100 %"],
    ]);
    expect(formatPercentage(null)).toBe("not measured");
    expect(formatQuantity(null, "V")).toBe("not measured");
    expect([9, 8.98, -1.5, -0.001].map((value) => formatQuantity(value, "V"))).toEqual([
      "9.00 V",
      "8.98 V",
      "−1.50 V",
      "0.00 V",
    ]);
    expect(formatValue("current", -1.5)).toBe("−1.50 A");
    expect(summarize({ percentage: 0.24, voltage: 2.16, power_supply_status: 1 })).toBe(
      "24 %, 2.16 V, charging",
    );
    expect(summarize({})).toBe("unknown");
  });
});

describe("the plots' scales", () => {
  it("give a steady value room, on tidy marks", () => {
    const [min, max] = rangeOf("voltage", 2.16, 2.16);
    expect(min).toBeLessThan(2.16);
    expect(max).toBeGreaterThan(2.16);
    for (const mark of marks(...rangeOf("voltage", 11.37, 11.71))) {
      expect(mark * 20).toBeCloseTo(Math.round(mark * 20));
    }
    expect(rangeOf("temperature", null, null)).toEqual([0, 1]);
    expect(marks(...rangeOf("current", -0.9, 6.5))).toEqual([-2.5, 0, 2.5, 5, 7.5]);
    expect(marks(...rangeOf("temperature", 24.9, 25.1))).toEqual([23, 24, 25, 26, 27]);
    expect(marks(0, 100)).toEqual([0, 25, 50, 75, 100]);
  });

  it("show a percentage that counts to 100 for what it is", () => {
    expect(rangeOf("percentage", 20, 30)).toEqual([0, 100]);
    expect(rangeOf("percentage", 2400, 2500)).toEqual([0, 2500]);
  });

  it("are low below the gateway's limit, unless it charges", () => {
    const low = (percentage: number | null, power_supply_status: number, lowBelow = 0.3) =>
      isLow({ percentage, power_supply_status }, lowBelow);
    expect([low(0.29, 2), low(0.3, 2), low(0.1, 1), low(0.1, 4), low(null, 2), low(0, 2, 0)]).toEqual([
      true,
      false,
      false,
      false,
      false,
      false,
    ]);
  });

  it("are believed as far as the gateway does", () => {
    const state = {
      ...battery,
      percentage: 12,
      voltage: 12_400,
      cell_voltage: [3.7, -1],
      power_supply_status: 9,
    };
    const fields = ["percentage", "voltage", "cell_voltage.1", "power_supply_status", "header.stamp"];
    const implausible = fields.map((field) => ({ field, value: -1, expected: "another value" }));
    expect(believed(batteryDocument(state, { percentage: null, implausible }))).toEqual({
      ...state,
      percentage: null,
      voltage: null,
      cell_voltage: [3.7, null],
      power_supply_status: 0,
    });
    const sent = batteryDocument({ ...battery, percentage: 12 }, { percentage: 0.12 });
    expect(believed(sent)).toEqual({ ...battery, percentage: 0.12 });
    expect(believed(batteryDocument(null))).toBeNull();
    expect(formatPercentage(12)).toBe("implausible (12)");
    expect(formatPercentage(-0.01)).toBe("implausible (-0.01)");
    expect([formatPercentage(1.02), formatPercentage(-0.0001)]).toEqual(["100 %", "0 %"]);
    const words = (value: number | string) => implausibleWords({ field: "f", value, expected: "0 to 1" });
    expect([words(12), words(-0.01), words("inf"), words(1e30)]).toEqual([
      "f is 12, but should be 0 to 1",
      "f is −0.01, but should be 0 to 1",
      "f is inf, but should be 0 to 1",
      "f is 1.00000e+30, but should be 0 to 1",
    ]);
  });

  it("say that a quantity is no longer measured", () => {
    const series = new BatterySeries();
    const words = (index: number | null = null, until = 10) =>
      describeQuantity(series.points, "current", index, until);
    expect(words()).toBe("–");
    series.push(1000, { ...battery, current: null });
    expect(words()).toBe("not measured");
    series.push(2000, { ...battery, current: 1.5 });
    expect(words()).toBe("1.50 A");
    series.push(3000, { ...battery, current: null });
    expect(words()).toBe("no longer measured, last 1.50 A");
    expect([words(1), words(2), words(null, 2.5)]).toEqual(["1.50 A", "–", "1.50 A"]);
  });

  it("have units, and say what was not measured", () => {
    expect(formatValue("voltage", 8.764)).toBe("8.76 V");
    expect(formatValue("percentage", 24)).toBe("24.0 %");
    expect(formatValue("current", null)).toBe("–");
    expect(formatSpread("voltage", 8.704, 8.81)).toBe(" (8.70 to 8.81)");
    expect(formatSpread("voltage", 8.761, 8.764)).toBe("");
  });
});
