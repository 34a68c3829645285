import { describe, expect, it } from "vitest";
import { PRESETS, parseCells, sameForm, toMessage } from "../src/battery/form";
import { evenly, voltageRange } from "../src/battery/plotOptions";
import { BatterySeries, WINDOW_S } from "../src/battery/series";
import { formatCells, formatPercentage, formatQuantity, statusWords, summarize } from "../src/battery/words";

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
        cell_voltage: "3.9, -, 3.8",
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

  it("refuses cells that are no numbers", () => {
    expect(parseCells("")).toEqual([]);
    expect(parseCells("3.9,,4")).toEqual([3.9, null, 4]);
    expect(parseCells("3.9 V")).toBeNull();
    expect(parseCells("Infinity")).toBeNull();
    expect(toMessage({ ...low.form, cell_temperature: "warm" })).toBeNull();
  });
});

describe("BatterySeries", () => {
  it("holds percentages and voltages over time", () => {
    const series = new BatterySeries();
    series.push(1000, 0.24, 2.16);
    series.push(2000, null, 2.2);
    expect(series.data).toEqual([
      [1, 2],
      [24, null],
      [2.16, 2.2],
    ]);
    expect(series.version).toBe(2);
  });

  it("is bounded, whatever the rate and however long it runs", () => {
    const series = new BatterySeries();
    for (let time = 0; time < 2 * WINDOW_S * 1000; time += 10) series.push(time, 0.5, 12);
    expect(series.length).toBeLessThanOrEqual(WINDOW_S * 10 * 1.1 + 64);
    expect(series.data[0].at(-1)).toBeCloseTo(2 * WINDOW_S, 1);
    expect(series.data[1]).toHaveLength(series.length);
    expect(series.data[2]).toHaveLength(series.length);
  });

  it("shows a pause as a gap, and leaves out what is older than the last", () => {
    const series = new BatterySeries();
    series.push(0, 0.5, 12);
    series.push(60_000, 0.6, 12);
    series.push(30_000, 0.1, 1);
    expect(series.data[1]).toEqual([50, null, 60]);
  });
});

describe("words", () => {
  it("say each cell, and alike ones once", () => {
    expect(formatCells([3.9, null, 4.0012], "V")).toBe("3.9, –, 4 V");
    expect(formatCells([25.001, 25.002, 25.003], "°C")).toBe("3 × 25 °C");
    expect(formatCells([1, 1], "V")).toBe("1, 1 V");
  });

  it("say what the numbers mean", () => {
    expect(statusWords(3)).toBe("Not charging");
    expect(statusWords(9)).toBe("Status 9");
    expect(formatPercentage(0.24)).toBe("24 %");
    expect(formatPercentage(null)).toBe("not measured");
    expect(formatQuantity(null, "V")).toBe("not measured");
    expect(summarize({ percentage: 0.24, voltage: 2.16, power_supply_status: 1 })).toBe(
      "24 %, 2.16 V, charging",
    );
    expect(summarize({})).toBe("unknown");
  });
});

describe("the plot's scales", () => {
  it("give a steady voltage room, and share their marks", () => {
    const [min, max] = voltageRange(2.16, 2.16);
    expect(min).toBeLessThan(2.16);
    expect(max).toBeGreaterThan(2.16);
    for (const mark of evenly(...voltageRange(11.37, 11.71), 4)) {
      expect(mark * 20).toBeCloseTo(Math.round(mark * 20));
    }
    expect(voltageRange(null, null)).toEqual([0, 1]);
    expect(evenly(0, 100, 4)).toEqual([0, 25, 50, 75, 100]);
  });
});
