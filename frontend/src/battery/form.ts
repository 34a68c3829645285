import type { BatteryStateInput } from "@dock-gateway/client";
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
  cell_voltage: readonly NumberInputValue[];
  cell_temperature: readonly NumberInputValue[];
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
  cell_voltage: [],
  cell_temperature: [],
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

const FLOATS = ["voltage", "current", "temperature", "charge", "capacity", "design_capacity"] as const;
const CHOICES = ["power_supply_health", "power_supply_technology"] as const;
const CELLS = ["cell_voltage", "cell_temperature"] as const;
const TEXTS = ["location", "serial_number"] as const;

/** The message to publish, or null where a field is not valid. */
export function toMessage(form: BatteryForm): BatteryStateInput | null {
  const numbers = [
    form.percent,
    ...FLOATS.map((field) => form[field]),
    ...CELLS.flatMap((field) => form[field]),
  ];
  if (!numbers.every(isNumber)) return null;
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
  for (const field of CELLS) if (form[field].length > 0) message[field] = form[field].map(toNumber);
  for (const field of TEXTS) if (form[field] !== "") message[field] = form[field];
  if (form.frame_id !== "") message.header = { frame_id: form.frame_id };
  return message;
}

/** Whether it is a number, or nothing. */
export function isNumber(value: NumberInputValue): boolean {
  return value === "" || Number.isFinite(Number(value));
}

export function toNumber(value: NumberInputValue): number | null {
  if (value === "") return null;
  const number = Number(value);
  return Number.isFinite(number) ? number : null;
}

export function sameForm(a: BatteryForm, b: BatteryForm): boolean {
  return JSON.stringify(toMessage(a)) === JSON.stringify(toMessage(b));
}
