import type { BatteryStateInput } from "../api/types";
import { CHARGING, NOT_CHARGING } from "./words";

/** A number field: a number, or text that is empty or not a number (yet). */
export type NumberInputValue = number | string;

/** What the editor holds: what is empty is not measured, and is left out of the message. */
export interface BatteryForm {
  /** 0 to 100, as people say it. */
  percent: NumberInputValue;
  voltage: NumberInputValue;
  current: NumberInputValue;
  temperature: NumberInputValue;
  charge: NumberInputValue;
  capacity: NumberInputValue;
  design_capacity: NumberInputValue;
  power_supply_status: number;
  power_supply_health: number;
  power_supply_technology: number;
  present: boolean;
  cell_voltage: string;
  cell_temperature: string;
  location: string;
  serial_number: string;
  frame_id: string;
}

const EMPTY: BatteryForm = {
  percent: "",
  voltage: "",
  current: "",
  temperature: "",
  charge: "",
  capacity: "",
  design_capacity: "",
  power_supply_status: 0,
  power_supply_health: 0,
  power_supply_technology: 0,
  present: false,
  cell_voltage: "",
  cell_temperature: "",
  location: "",
  serial_number: "",
  frame_id: "",
};

/** The two commands of the tutorial. */
export const PRESETS = [
  {
    name: "Low battery, not charging",
    form: { ...EMPTY, percent: 24, voltage: 2.16, power_supply_status: NOT_CHARGING },
  },
  {
    name: "On the dock, charging",
    form: { ...EMPTY, percent: 24, voltage: 2.16, power_supply_status: CHARGING },
  },
] as const satisfies readonly { name: string; form: BatteryForm }[];

/** The form of a list field: numbers between commas; a dash, or nothing, for a cell that is not measured. */
export function parseCells(text: string): (number | null)[] | null {
  if (text.trim() === "") return [];
  const cells = text.split(",").map((part) => {
    const trimmed = part.trim();
    return trimmed === "" || trimmed === "-" || trimmed === "–" ? null : Number(trimmed);
  });
  return cells.every((cell) => cell === null || Number.isFinite(cell)) ? cells : null;
}

const FLOATS = ["voltage", "current", "temperature", "charge", "capacity", "design_capacity"] as const;
const CHOICES = ["power_supply_health", "power_supply_technology"] as const;
const CELLS = ["cell_voltage", "cell_temperature"] as const;
const TEXTS = ["location", "serial_number"] as const;

/** The message to publish, or null where a field is not valid. */
export function toMessage(form: BatteryForm): BatteryStateInput | null {
  const message: BatteryStateInput = {};
  for (const field of FLOATS) {
    const value = toNumber(form[field]);
    if (value !== null) message[field] = value;
  }
  const percent = toNumber(form.percent);
  if (percent !== null) message.percentage = Number((percent / 100).toFixed(6));
  message.power_supply_status = form.power_supply_status;
  for (const field of CHOICES) if (form[field] > 0) message[field] = form[field];
  if (form.present) message.present = true;
  for (const field of CELLS) {
    const cells = parseCells(form[field]);
    if (cells === null) return null;
    if (cells.length > 0) message[field] = cells;
  }
  for (const field of TEXTS) if (form[field] !== "") message[field] = form[field];
  if (form.frame_id !== "") message.header = { frame_id: form.frame_id };
  return message;
}

export function toNumber(value: NumberInputValue): number | null {
  if (value === "") return null;
  const number = Number(value);
  return Number.isFinite(number) ? number : null;
}

export function sameForm(a: BatteryForm, b: BatteryForm): boolean {
  return JSON.stringify(toMessage(a)) === JSON.stringify(toMessage(b));
}
