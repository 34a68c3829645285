import { lastUpTo } from "../ui/crosshair";
import type { Message } from "../ui/messageWords";
import { FieldsFound } from "./fields";

export interface FeedbackRow {
  /** The event's id; ids sort as text, in the order of time. */
  id: string;
  /** In the gateway's time (ms). */
  time: number;
  message: Message;
}

/** Beyond this number every second message of the older half is left out: a page may be open for days. */
export const MAX_ROWS = 10_000;

/** The feedback of one goal in the order of its ids, each message once, whichever way and however often it came. */
export class FeedbackLog {
  #rows: FeedbackRow[] = [];
  /** Changes with every change. */
  version = 0;
  /** Changes where rows were not only added at the end. */
  generation = 0;
  /** Whether messages were left out for the sake of memory. */
  thinned = false;
  readonly fields = new FieldsFound();
  readonly #limit: number;

  constructor(limit = MAX_ROWS) {
    this.#limit = limit;
  }

  /** Oldest first. */
  get rows(): readonly FeedbackRow[] {
    return this.#rows;
  }

  /** @param rows In the order of their ids. */
  add(rows: readonly FeedbackRow[]): void {
    const fresh = rows.filter(({ id }) => !this.#has(id));
    if (fresh.length === 0) return;
    this.version += 1;
    for (const row of fresh) this.fields.look(row.message);
    const last = this.#rows.at(-1);
    if (last === undefined || (fresh[0]?.id ?? "") > last.id) {
      for (const row of fresh) this.#rows.push(row);
    } else {
      this.#rows = [...this.#rows, ...fresh].sort((a, b) => (a.id < b.id ? -1 : 1));
      this.generation += 1;
    }
    if (this.#rows.length > this.#limit) this.#thin();
  }

  #has(id: string): boolean {
    return this.#rows[indexOf(this.#rows, id)]?.id === id;
  }

  #thin(): void {
    const half = this.#rows.length >> 1;
    this.#rows = this.#rows.filter((_, index) => index >= half || index % 2 === 0);
    this.generation += 1;
    this.thinned = true;
  }
}

/** Where a row is among rows in the order of their ids, or the first after it. */
export function indexOf(rows: readonly FeedbackRow[], id: string): number {
  let [low, high] = [0, rows.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((rows[middle]?.id ?? "") < id) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The last of the rows that had come at a time (ms), which may be rounded. */
export function rowIndexAt(rows: readonly FeedbackRow[], time: number): number {
  return lastUpTo(time + 0.5, rows.length, (index) => rows[index]?.time ?? 0);
}

export function rowAt(rows: readonly FeedbackRow[], time: number): FeedbackRow | undefined {
  return rows[rowIndexAt(rows, time)];
}
