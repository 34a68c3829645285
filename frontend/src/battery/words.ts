import type { BatteryState, Implausible } from "@dock-gateway/client";
import { fixed, shortest } from "../ui/numbers";

/** sensor_msgs/BatteryState POWER_SUPPLY_STATUS_… */
export const CHARGING = 1;
export const NOT_CHARGING = 3;
export const FULL = 4;

export const STATUS_WORDS = ["Unknown", "Charging", "Discharging", "Not charging", "Full"] as const;

export const HEALTH_WORDS = [
  "Unknown",
  "Good",
  "Overheated",
  "Dead",
  "Overvoltage",
  "Unspecified failure",
  "Cold",
  "Watchdog timer expired",
  "Safety timer expired",
] as const;

export const TECHNOLOGY_WORDS = [
  "Unknown",
  "NiMH",
  "Li-ion",
  "LiPo",
  "LiFePO4",
  "NiCd",
  "LiMn",
  "Ternary lithium",
  "VRLA (lead-acid)",
] as const;

/** Whether it is low and not charging. */
export function isLow(
  { percentage, power_supply_status: status }: Pick<BatteryState, "percentage" | "power_supply_status">,
  lowBelow: number,
): boolean {
  return percentage !== null && percentage < lowBelow && status !== CHARGING && status !== FULL;
}

/**
 * The status of a battery as every page says it.
 *
 * @param charging What the gateway knows beyond the status, as of a docked robot whose driver sends UNKNOWN; null where that is nothing.
 */
export function statusOf(status: number, charging: boolean | null): number {
  return status === 0 && charging === true ? CHARGING : status;
}

export function statusWords(status: number): string {
  return STATUS_WORDS[status] ?? `Status ${status}`;
}

const NOT_MEASURED = "not measured";

/** The number of decimals: one for a temperature, else two, as a battery measures no more exactly. */
function digits(value: number, unit: string): string {
  return fixed(value, unit === "°C" ? 1 : 2);
}

export function formatQuantity(value: number | null | undefined, unit: string): string {
  return value === null || value === undefined ? NOT_MEASURED : `${digits(value, unit)} ${unit}`;
}

/** What real drivers send for an empty and for a full battery. */
const LEAST = -0.001;
const MOST = 1.02;

/**
 * `percentage` is 0 to 1; one that cannot be is shown as it was sent. Rounded down, so that 19.96 % is not 20 % beside
 * "fell below 20 %"; a float32 of 0.29 is 29 %.
 */
export function formatPercentage(percentage: number | null | undefined): string {
  if (percentage === null || percentage === undefined) return NOT_MEASURED;
  if (percentage < LEAST || percentage > MOST) return `implausible (${percentage})`;
  return `${Math.floor(Math.min(100, Math.max(0, percentage * 100 + 1e-4)))} %`;
}

/** `24 %, 2.16 V, not charging` */
export function summarize(
  state: Partial<Pick<BatteryState, "percentage" | "voltage" | "power_supply_status">>,
): string {
  const parts = [statusWords(state.power_supply_status ?? 0).toLowerCase()];
  if (typeof state.voltage === "number") parts.unshift(formatQuantity(state.voltage, "V"));
  if (typeof state.percentage === "number") parts.unshift(formatPercentage(state.percentage));
  return parts.join(", ");
}

/** The battery state in a message of our own docking actions, `current_battery_state` and the like; null in any other. */
export function batteryIn(message: object | null | undefined, field: string): BatteryState | null {
  return (message as Record<string, BatteryState | undefined> | null | undefined)?.[field] ?? null;
}

/** Of each cell: `3.90, –, 4.00 V`, and `7 × 25.0 °C` where they are all alike. */
export function formatCells(values: readonly (number | null)[], unit: string): string {
  const texts = values.map((value) => (value === null ? "–" : digits(value, unit)));
  const [first] = texts;
  const alike = texts.length > 2 && texts.every((text) => text === first);
  return `${alike ? `${texts.length} × ${first}` : texts.join(", ")} ${unit}`;
}

/** `percentage is 12, but should be 0 to 1` */
export function implausibleWords({ field, value, expected }: Implausible): string {
  const number = typeof value === "number" ? plausible(value) : value;
  return `${field} is ${number}, but should be ${expected}`;
}

function plausible(value: number): string {
  return Math.abs(value) < 1e6 ? shortest(value, 3) : value.toPrecision(6);
}
