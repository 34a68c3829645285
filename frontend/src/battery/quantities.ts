import type { Quantity } from "../store/batterySeries";
import { fixed } from "../ui/numbers";
import { BATTERY_COLORS } from "../ui/tokens";

interface Shape {
  name: string;
  unit: string;
  /** The number of decimals next to the plot. */
  decimals: number;
  /** Every mark is a multiple of this. */
  tidy: number;
  /** The least room above and below. */
  room: number;
  light: string;
  dark: string;
}

export const SHAPES: Record<Quantity, Shape> = {
  voltage: {
    name: "Voltage",
    unit: "V",
    decimals: 2,
    tidy: 0.05,
    room: 0.1,
    ...BATTERY_COLORS.voltage,
  },
  percentage: {
    name: "Percentage",
    unit: "%",
    decimals: 0,
    tidy: 25,
    room: 0,
    ...BATTERY_COLORS.percentage,
  },
  current: {
    name: "Current",
    unit: "A",
    decimals: 2,
    tidy: 0.05,
    room: 0.1,
    ...BATTERY_COLORS.current,
  },
  temperature: {
    name: "Temperature",
    unit: "°C",
    decimals: 1,
    tidy: 0.5,
    room: 1,
    ...BATTERY_COLORS.temperature,
  },
};

/** `8.76 V`; `–` where it was not measured. */
export function formatValue(quantity: Quantity, value: number | null | undefined): string {
  return value === null || value === undefined ? "–" : `${digits(quantity, value)} ${SHAPES[quantity].unit}`;
}

/** ` (8.70 to 8.81)` where a point is more than one measurement, and they differ. */
export function formatSpread(
  quantity: Quantity,
  least: number | null | undefined,
  most: number | null | undefined,
): string {
  if (typeof least !== "number" || typeof most !== "number") return "";
  const [low, high] = [digits(quantity, least), digits(quantity, most)];
  return low === high ? "" : ` (${low} to ${high})`;
}

function digits(quantity: Quantity, value: number): string {
  return fixed(value, Math.max(SHAPES[quantity].decimals, 1));
}

const ROWS = 4;
const TIDY_MULTIPLES = [1, 2, 3, 4, 5, 6, 8];

/** Room around what is shown, so that a steady value is not a line on the edge; every mark on a tidy number. */
export function rangeOf(quantity: Quantity, min: number | null, max: number | null): [number, number] {
  if (quantity === "percentage") return [Math.min(0, min ?? 0), Math.max(100, max ?? 0)];
  if (min === null || max === null) return [0, 1];
  const { tidy, room: least } = SHAPES[quantity];
  const room = Math.max((max - min) * 0.1, Math.abs(max) * 0.02, least);
  for (let decade = tidy; Number.isFinite(decade); decade *= 10) {
    for (const multiple of TIDY_MULTIPLES) {
      const step = multiple * decade;
      const low = Math.floor((min - room) / step) * step;
      if (low + ROWS * step >= max + room) return [low, low + ROWS * step];
    }
  }
  return [min, max];
}

/** The marks from `min` to `max`. */
export function marks(min: number, max: number): number[] {
  return Array.from({ length: ROWS + 1 }, (_, index) => min + ((max - min) * index) / ROWS);
}
