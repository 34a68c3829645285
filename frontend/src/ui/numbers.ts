const formats = new Map<number, Intl.NumberFormat>();

/** A number with always as many decimals, so that it does not jitter: no negative zero, and a minus sign as wide as a digit. */
export function fixed(value: number, decimals: number): string {
  let format = formats.get(decimals);
  if (format === undefined) {
    format = new Intl.NumberFormat(undefined, {
      minimumFractionDigits: decimals,
      maximumFractionDigits: decimals,
    });
    formats.set(decimals, format);
  }
  const text = format.format(value);
  return text.replace("-", /[1-9]/.test(text) ? "−" : "");
}
