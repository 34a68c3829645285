import { lastUpTo } from "../ui/crosshair";
import { isMessage, type Message } from "../ui/messageWords";
import type { PlotSource } from "../ui/plotData";
import { FieldsFound, type NumericField, numberAt } from "./fields";

export interface FeedbackRow {
  /** The event's id; ids sort as text, in the order of time. */
  id: string;
  /** In the gateway's time (ms). */
  time: number;
  message: Message;
}

/** Beyond this number half of the older messages are left out: a page may be open for days. */
const MAX_ROWS = 10_000;

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

  /**
   * Of each two older messages one is left out, now the second and now the first: messages may take turns. Those with
   * the extreme values of a field stay.
   */
  #thin(): void {
    const half = this.#rows.length >> 1;
    const older = this.#rows.slice(0, half);
    const extremes = new Set(this.fields.all.flatMap((field) => extremesOf(older, field)));
    this.#rows = this.#rows.filter(
      (row, index) => index >= half || index % 4 === 0 || index % 4 === 3 || extremes.has(row),
    );
    this.generation += 1;
    this.thinned = true;
  }
}

/** The rows with the least and the greatest value of a field; none where it was never measured. */
function extremesOf(rows: readonly FeedbackRow[], field: NumericField): FeedbackRow[] {
  let [least, greatest] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  const found: FeedbackRow[] = [];
  for (const row of rows) {
    const value = numberAt(row.message, field);
    if (value === null) continue;
    if (value < least) [least, found[0]] = [value, row];
    if (value > greatest) [greatest, found[1]] = [value, row];
  }
  return found;
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
function saysTheSame(one: unknown, other: unknown): boolean {
  if (Array.isArray(one) && Array.isArray(other))
    return one.length === other.length && one.every((item, index) => saysTheSame(item, other[index]));
  if (!isMessage(one) || !isMessage(other)) return one === other;
  return Object.entries(one).every(([name, value]) => name === "stamp" || saysTheSame(value, other[name]));
}

/** Fields of a goal's feedback over the time since the goal began (s). Reads each message once. */
export class FeedbackPlotSource implements PlotSource {
  #times: number[] = [];
  #values: (number | null)[][] = [];
  #generation = -1;

  constructor(
    private readonly log: FeedbackLog,
    readonly fields: readonly NumericField[],
    private readonly start: number,
  ) {}

  get version(): number {
    return this.log.version;
  }

  read(): [number[], ...(number | null)[][]] {
    if (this.#generation !== this.log.generation) {
      this.#generation = this.log.generation;
      this.#times = [];
      this.#values = this.fields.map(() => []);
    }
    const { rows } = this.log;
    for (let index = this.#times.length; index < rows.length; index += 1) {
      const row = rows[index];
      if (row === undefined) break;
      this.#times.push((row.time - this.start) / 1000);
      for (const [at, field] of this.fields.entries()) this.#values[at]?.push(numberAt(row.message, field));
    }
    return [this.#times, ...this.#values];
  }
}
