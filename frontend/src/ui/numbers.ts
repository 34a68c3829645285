// Numbers that are measured are written as people do where the browser is from: `1,5` in German. The values of messages
// are written as ROS tools do, by `alike`.

const formats = new Map<string, Intl.NumberFormat>();

/** A number with always as many decimals, so that it does not jitter: no negative zero, and a minus sign as wide as a digit. */
export function fixed(value: number, decimals: number): string {
  return written(value, decimals, decimals);
}

/** A number with as many decimals as it needs, up to some: `1.5`, `2`. */
export function shortest(value: number, decimals: number): string {
  return written(value, 0, decimals);
}

function written(value: number, least: number, most: number): string {
  const key = `${least} ${most}`;
  let format = formats.get(key);
  if (format === undefined) {
    format = new Intl.NumberFormat(undefined, { minimumFractionDigits: least, maximumFractionDigits: most });
    formats.set(key, format);
  }
  return minusSign(format.format(value));
}

/** A minus sign as wide as a digit, and none before a zero. */
function minusSign(text: string): string {
  return text.replace(/^-/, /[1-9]/.test(text) ? "−" : "");
}

/** What numbers that are read together (a column, a plot, a field that changes) have in common. */
export interface Digits {
  /** The most that any of them has. */
  decimals: number;
  /** The power of ten of the largest: 1 for 12.5. */
  magnitude: number;
}

export const NO_DIGITS: Digits = { decimals: 0, magnitude: Number.NEGATIVE_INFINITY };

/** A float32 in its shortest text has no more. */
const SIGNIFICANT = 9;

/** What they have in common with one number more; the same object where it changes nothing. */
export function withNumber(digits: Digits, value: number): Digits {
  const decimals = Math.max(digits.decimals, decimalsOf(value));
  const magnitude = Math.max(digits.magnitude, Math.floor(Math.log10(Math.abs(value))));
  return decimals === digits.decimals && magnitude === digits.magnitude ? digits : { decimals, magnitude };
}

/** How many decimals the shortest text of a number has: 2 for 8.95, 0 for 9. */
export function decimalsOf(value: number): number {
  if (Number.isInteger(value)) return 0;
  const [mantissa = "", exponent = "0"] = String(value).split("e");
  const point = mantissa.indexOf(".");
  return Math.max(0, (point < 0 ? 0 : mantissa.length - point - 1) - Number(exponent));
}

/** Enough to compare values at a glance; a message has all of them. */
export const COMPARED = 6;

/** A number of a message like those that are read with it: `9.00` next to `8.95`. As ROS tools write it: a point, no groups. */
export function alike(value: number, { decimals, magnitude }: Digits, significant = SIGNIFICANT): string {
  if (magnitude < -4 && value !== 0) return minusSign(value.toExponential(3)).replace("e-", "e−");
  const whole = Math.max(0, magnitude) + 1;
  return minusSign(value.toFixed(Math.max(0, Math.min(decimals, significant - whole))));
}
