import { isMessage } from "../ui/messageWords";
import type { FeedbackLog, FeedbackRow } from "./feedbackLog";

/** The rows of a log whose message says something else than the one before. Compares each message once. */
export class ChangedRows {
  #rows: FeedbackRow[] = [];
  #compared = 0;
  #generation = -1;

  constructor(private readonly log: FeedbackLog) {}

  /** Oldest first. */
  read(): readonly FeedbackRow[] {
    const { rows, generation } = this.log;
    if (this.#generation !== generation) {
      this.#generation = generation;
      this.#rows = [];
      this.#compared = 0;
    }
    for (; this.#compared < rows.length; this.#compared += 1) {
      const [row, before] = [rows[this.#compared], rows[this.#compared - 1]];
      if (row !== undefined && !saysTheSame(row.message, before?.message)) this.#rows.push(row);
    }
    return this.#rows;
  }
}

/** Whether two messages differ in nothing but the times of their measurements. */
export function saysTheSame(one: unknown, other: unknown): boolean {
  if (Array.isArray(one) && Array.isArray(other))
    return one.length === other.length && one.every((item, index) => saysTheSame(item, other[index]));
  if (!isMessage(one) || !isMessage(other)) return one === other;
  return Object.entries(one).every(([name, value]) => name === "stamp" || saysTheSame(value, other[name]));
}
