export const SPEEDS = [1, 4, 16] as const;

export type Speed = (typeof SPEEDS)[number];

/** The moment (s) that an address holds, within a goal of that length; null where it holds none. */
export function momentIn(text: string | null, length: number): number | null {
  const moment = text === null || text.trim() === "" ? Number.NaN : Number(text);
  return Number.isNaN(moment) ? null : Math.min(length, Math.max(0, moment));
}

/** As the address holds it, to the millisecond. */
export function momentText(moment: number): string {
  return String(Number(moment.toFixed(3)));
}

/** One step of the arrow keys (s): a few hundred of them are the goal. */
export function stepOf(length: number): number {
  return length <= 60 ? 0.1 : Math.ceil(length / 600);
}

/** Where it plays to: from the beginning again at the end. */
export function playFrom(moment: number | null, length: number): number {
  return moment === null || moment >= length ? 0 : moment;
}
