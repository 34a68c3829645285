// @vitest-environment jsdom

import {
  ClientError,
  type GatewayEvent,
  type GoalEvent,
  type GoalHistory,
  type LiveGoal,
  type StreamHandlers,
} from "@dock-gateway/client";
import { describe, expect, it, type Mock, vi } from "vitest";
import type { GoalsApi } from "../src/api/goals";
import { timelineOf } from "../src/goal/timeline";
import { ChangedRows, FeedbackLog } from "../src/goals/feedbackLog";
import { FieldsFound, mostTelling, numberAt } from "../src/goals/fields";
import { GoalWatch } from "../src/goals/watch";
import { at, battery, feedback, goal, result, START, snapshot, status } from "./events";

const history = (events: GatewayEvent[], next_after: string | null = null, complete = true): GoalHistory => ({
  events: events as GoalEvent[],
  next_after,
  complete,
});

interface Asked {
  goal: Mock<GoalsApi["goal"]>;
  history: Mock<GoalsApi["history"]>;
}

/** A goal that is watched: what the gateway answers, and the stream to tell events by. */
async function watching(change: Partial<Asked> = {}, first: LiveGoal = goal("a")) {
  const api: Asked = {
    goal: vi.fn<GoalsApi["goal"]>(async () => first),
    history: vi.fn<GoalsApi["history"]>(async () => history([])),
    ...change,
  };
  const stream = { handlers: null as StreamHandlers | null, close: vi.fn() };
  const open = vi.fn((handlers: StreamHandlers) => {
    stream.handlers = handlers;
    return stream.close;
  });
  const watch = new GoalWatch("a", api as unknown as GoalsApi, open, () => START);
  await watch.open();
  const tell = (...events: GatewayEvent[]) => {
    for (const event of events) stream.handlers?.onEvent(event);
  };
  return { watch, api, open, stream, tell };
}

const ids = (watch: GoalWatch) => watch.log.rows.map(({ id }) => id);

describe("a goal that is watched", () => {
  it("has what came before and what comes, without a gap or a double", async () => {
    const past = [status("a"), feedback("a"), feedback("a")];
    const both = feedback("a");
    const later = feedback("a");
    let answer: (page: GoalHistory) => void = () => {};
    const asked = new Promise<GoalHistory>((resolve) => {
      answer = resolve;
    });
    const { watch, tell, api } = await watching({ history: vi.fn(() => asked) });
    expect(api.history).not.toHaveBeenCalled();
    tell(snapshot({ goals: [goal("a")] }), both, later);
    answer(history([...past, both]));
    await vi.waitFor(() => expect(watch.get("past").loading).toBe(false));
    expect(ids(watch)).toEqual([past[1], past[2], both, later].map((event) => (event as { id: string }).id));
    expect(watch.get("statuses")).toHaveLength(1);
  });

  it("reads the history page by page", async () => {
    const [one, two] = [feedback("a"), feedback("a")];
    const pages = vi
      .fn<GoalsApi["history"]>()
      .mockResolvedValueOnce(history([one], one.id, false))
      .mockResolvedValueOnce(history([two], null, false));
    const { watch } = await watching({ history: pages }, goal("a", { status: "succeeded" }));
    await vi.waitFor(() =>
      expect(watch.get("past")).toEqual({ loading: false, complete: false, error: null }),
    );
    expect(pages.mock.calls).toEqual([
      ["a", null],
      ["a", one.id],
    ]);
    expect(ids(watch)).toEqual([one.id, two.id]);
  });

  it("needs no stream once it has ended", async () => {
    const { open } = await watching({}, goal("a", { status: "aborted" }));
    expect(open).not.toHaveBeenCalled();
  });

  it("asks for what a slow page was not sent, and for what a gap has swallowed", async () => {
    const { watch, tell, api } = await watching();
    const [first, missed, next] = [feedback("a"), feedback("a"), feedback("a")];
    api.history.mockResolvedValueOnce(history([first]));
    tell(snapshot({ goals: [goal("a")] }));
    await vi.waitFor(() => expect(ids(watch)).toEqual([first.id]));
    api.history.mockResolvedValueOnce(history([missed, next]));
    tell({ type: "dropped", time: at(3), count: 1 }, next);
    await vi.waitFor(() => expect(ids(watch)).toEqual([first.id, missed.id, next.id]));
    expect(api.history).toHaveBeenLastCalledWith("a", first.id);
    tell({ type: "gap", time: at(4), after: next.id, count: 0 }, snapshot({ goals: [goal("a")] }));
    await vi.waitFor(() => expect(api.history).toHaveBeenLastCalledWith("a", next.id));
  });

  it("closes its stream when the goal has ended, and asks once more for the whole", async () => {
    const { watch, tell, api, stream } = await watching();
    tell(snapshot({ goals: [goal("a")] }));
    const whole = goal("a", { status: "succeeded", finished_at: at(9), feedback_count: 7 });
    api.goal.mockResolvedValueOnce(whole);
    tell(result("a"), status("a", { status: "succeeded" }, 3));
    await vi.waitFor(() => expect(watch.get("goal")).toEqual(whole));
    expect(stream.close).toHaveBeenCalledTimes(1);
    expect(watch.get("connection")).toBeNull();
  });

  it("leaves out events of other goals", async () => {
    const { watch, tell } = await watching();
    tell(snapshot({ goals: [goal("b"), goal("a")] }), feedback("b"), status("b"));
    await vi.waitFor(() => expect(watch.get("past").loading).toBe(false));
    expect(ids(watch)).toEqual([]);
    expect(watch.get("goal")?.goal_id).toBe("a");
  });

  it("says why there is none, and tries once more when asked", async () => {
    const missing = new ClientError("goal_not_found", "The gateway does not know this goal", "no goal a");
    const { watch, api } = await watching({ goal: vi.fn<GoalsApi["goal"]>().mockRejectedValueOnce(missing) });
    expect(watch.get("error")).toBe(missing);
    api.goal.mockResolvedValueOnce(goal("a"));
    await watch.open();
    expect([watch.get("error"), watch.get("goal")?.goal_id]).toEqual([null, "a"]);
  });

  it("keeps what it has where the history fails, and says so", async () => {
    const failure = new ClientError("history_unavailable", "The history does not answer", "no");
    const { watch, tell } = await watching({ history: vi.fn().mockRejectedValue(failure) });
    tell(snapshot({ goals: [goal("a")] }), feedback("a"));
    await vi.waitFor(() => expect(watch.get("past").error).toBe(failure));
    expect(ids(watch)).toHaveLength(1);
  });
});

describe("the log of feedback", () => {
  const row = (index: number) => ({ id: `e${index}`.padStart(3, "0"), time: index, message: { n: index } });

  it("thins out its older half beyond its limit, and says so", () => {
    const log = new FeedbackLog(8);
    log.add(Array.from({ length: 8 }, (_, index) => row(index)));
    expect([log.thinned, log.generation]).toEqual([false, 0]);
    log.add([row(8)]);
    expect(log.rows.map(({ time }) => time)).toEqual([0, 3, 4, 5, 6, 7, 8]);
    expect([log.thinned, log.generation]).toEqual([true, 1]);
  });

  it("keeps fields that take turns, the ends and the extreme values, however often it is thinned out", () => {
    for (const period of [1, 2, 3, 4, 5, 7, 8])
      for (const spike of [5, 6, 7, 8, 101]) {
        const log = new FeedbackLog(64);
        for (let index = 0; index < 500; index += 1) {
          const value = index === spike ? 99 : (index * 7) % 11;
          log.add([
            {
              id: `e${index}`.padStart(5, "0"),
              time: index,
              message: { [`turn${index % period}`]: value, sometimes: index % 8 === 1 ? 1 : null },
            },
          ]);
        }
        expect(log.rows.length).toBeLessThan(128);
        expect([log.rows[0]?.time, log.rows.at(-1)?.time]).toEqual([0, 499]);
        for (const field of log.fields.all) {
          const left = log.rows
            .map(({ message }) => numberAt(message, field))
            .filter((each) => each !== null);
          expect([Math.min(...left), Math.max(...left)]).toEqual([field.min, field.max]);
        }
      }
  });
});

describe("rows that changed", () => {
  const row = (index: number, message: Record<string, unknown>) => ({
    id: `e${index}`,
    time: index,
    message,
  });
  const stamped = (sec: number, value: unknown) => ({
    header: { stamp: { sec, nanosec: 0 } },
    cells: [value],
  });

  it("say something else than the row before, whatever their stamps", () => {
    const log = new FeedbackLog();
    const changes = new ChangedRows(log);
    const times = () => changes.read().map(({ time }) => time);
    log.add([row(1, stamped(1, 9)), row(2, stamped(2, 9)), row(4, stamped(4, null))]);
    expect(times()).toEqual([1, 4]);
    log.add([row(5, stamped(5, null)), row(6, stamped(6, 9))]);
    expect(times()).toEqual([1, 4, 6]);
    // What comes late may change what is after it.
    log.add([row(3, stamped(3, null))]);
    expect(times()).toEqual([1, 3, 6]);
  });
});

describe("fields to plot", () => {
  const found = (...messages: Record<string, unknown>[]) => {
    const fields = new FieldsFound();
    for (const message of messages) fields.look(message);
    return fields.all;
  };

  it("are the numbers that were measured", () => {
    const names = found({ current_battery_state: { ...battery, cell_voltage: [3.9, null] } }).map(
      ({ name }) => name,
    );
    expect(names).toEqual([
      "current_battery_state.voltage",
      "current_battery_state.percentage",
      "current_battery_state.power_supply_status",
      "current_battery_state.power_supply_health",
      "current_battery_state.power_supply_technology",
      "current_battery_state.cell_voltage.0",
    ]);
  });

  it("of a sequence that grows are its last item and its length, too", () => {
    const message = { partial_sequence: [0, 1, 1, 2] };
    const fields = found({ partial_sequence: [0, 1] }, message);
    expect(fields.slice(0, 2).map((field) => [field.name, numberAt(message, field)])).toEqual([
      ["partial_sequence (last)", 2],
      ["partial_sequence (length)", 4],
    ]);
    expect(mostTelling(fields)?.name).toBe("partial_sequence (last)");
  });

  it("of a duration are its seconds", () => {
    const message = { left: { sec: 2, nanosec: 500_000_000 } };
    const [field] = found(message);
    expect(field?.name).toBe("left");
    expect(field && numberAt(message, field)).toBe(2.5);
    expect(field && numberAt({}, field)).toBeNull();
  });
});

describe("the timeline", () => {
  it("tells each status and stage with its time and how long it lasted", () => {
    const goalNow = goal("a", { status: "aborted", stage: "ABORTED", retries: 1, finished_at: at(9) });
    const error = { code: "failed_to_charge", detail: "no current" };
    const events = [
      status("a", { status: "accepted" }, 1),
      status("a", { status: "executing", stage: "CONTROLLING", retries: 0 }, 2),
      status("a", { status: "executing", stage: "CONTROLLING", retries: 0 }, 3),
      status("a", { status: "executing", stage: "CONTROLLING", retries: 0, stalled: true }, 4),
      status("a", { status: "executing", stage: "RETRY", retries: 1 }, 5),
      status("a", { status: "aborted", stage: "ABORTED", retries: 1, error }, 9),
    ];
    const entries = timelineOf(goalNow, events, true);
    expect(entries.map(({ change, time, lasted }) => [change, ((time ?? 0) - START) / 1000, lasted])).toEqual(
      [
        [{ kind: "status", status: "accepted", error: null }, 1, 1000],
        [{ kind: "status", status: "executing", error: null }, 2, 0],
        [{ kind: "stage", stage: "CONTROLLING", retries: 0 }, 2, 2000],
        [{ kind: "silence", silent: true }, 4, 1000],
        [{ kind: "silence", silent: false }, 5, 0],
        [{ kind: "stage", stage: "RETRY", retries: 1 }, 5, 4000],
        [{ kind: "status", status: "aborted", error }, 9, null],
      ],
    );
    expect(new Set(entries.map(({ key }) => key)).size).toBe(entries.length);
  });

  it("takes what is told late for no step back: stamps are of two clocks", () => {
    const events = [
      status("a", { status: "pending" }, 1),
      status("a", { status: "executing" }, 2),
      status("a", { status: "pending", stage: "INITIAL_PERCEPTION" }, 3),
      status("a", { status: "executing", stage: "CONTROLLING" }, 4),
    ];
    const entries = timelineOf(goal("a", { status: "executing", stage: "CONTROLLING" }), events, true);
    const told = entries.map(({ change }) =>
      "status" in change ? change.status : "stage" in change && change.stage,
    );
    expect(told).toEqual(["pending", "executing", "INITIAL_PERCEPTION", "CONTROLLING"]);
  });

  it("takes what the goal itself tells where events are missing", () => {
    const [only] = timelineOf(goal("a", { status: "succeeded", finished_at: at(4) }), [], false);
    expect(only).toMatchObject({ time: START + 4000, change: { status: "succeeded" }, lasted: null });
  });

  it("invents no time where the events before are missing: a goal's last update is not when its stage began", () => {
    const running = goal("a", { stage: "CONTROLLING", updated_at: at(60) });
    expect(timelineOf(running, [], false).map(({ time, lasted }) => [time, lasted])).toEqual([
      [null, null],
      [null, null],
    ]);
    const events = [status("a", { stage: "CONTROLLING" }, 50), status("a", { stage: "WAIT_FOR_CHARGE" }, 55)];
    const late = timelineOf(goal("a", { stage: "WAIT_FOR_CHARGE" }), events, false);
    expect(late.map(({ time, lasted }) => [time, lasted])).toEqual([
      [null, null],
      [null, null],
      [START + 55_000, null],
    ]);
  });
});
