const WINDOW_MS = 3000;

/** Messages a second over the last three seconds, or null where that is too few to say. */
export function rate(arrivals: readonly number[], now: number): number | null {
  const recent = arrivals.filter((time) => now - time <= WINDOW_MS);
  const [first] = recent;
  const last = recent.at(-1);
  if (first === undefined || last === undefined || last <= first) return null;
  return ((recent.length - 1) * 1000) / (last - first);
}
