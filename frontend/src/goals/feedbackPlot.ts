import type { PlotSource } from "../ui/plotData";
import type { FeedbackLog } from "./feedbackLog";
import { type NumericField, numberAt } from "./fields";

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
