import type { GatewayEvent, LiveGoal } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { meaning, outcome } from "../src/goal/words";
import { mergeGoals, newestFirst } from "../src/store/goals";
import { reduce } from "../src/store/reducer";
import {
  initialState,
  MAX_ARRIVALS,
  MAX_FEEDBACK,
  MAX_GOALS,
  MAX_SEEN,
  type State,
} from "../src/store/state";
import {
  at,
  battery,
  batteryEvent,
  cmdVel,
  feedback,
  goal,
  idlePublisher,
  latched,
  result,
  START,
  server,
  simulator,
  snapshot,
  status,
  undockServer,
} from "./events";

/** The state of a page that is connected. */
const connected = reduce(initialState, snapshot(), START);

function stateAfter(events: GatewayEvent[], state: State = connected): State {
  return events.reduce((each, event) => reduce(each, event, START), state);
}

describe("snapshot", () => {
  it("shows all that the gateway knows", () => {
    const state = stateAfter([
      snapshot({
        goals: [goal("a")],
        battery: {
          state: battery,
          percentage: 0.24,
          implausible: [],
          stale: false,
          stale_after_s: 5,
          low_below: 0.2,
          received_at: at(-1),
        },
        battery_publisher: { ...idlePublisher, active: true, rate_hz: 1, state: battery },
      }),
    ]);
    expect(state.goals.get("a")?.status).toBe("executing");
    expect(state.battery).toEqual({
      state: battery,
      implausible: [],
      receivedAt: START - 1000,
      staleAfterS: 5,
      lowBelow: 0.2,
    });
    expect(state.publisher?.active).toBe(true);
    expect(state.actionServer).toEqual(server);
  });

  it("of a restarted gateway replaces running goals and keeps ended ones", () => {
    const before = stateAfter([snapshot({ goals: [goal("ran"), goal("ended", { status: "succeeded" })] })]);
    const state = stateAfter([snapshot({ goals: [goal("new")] })], before);
    expect([...state.goals.keys()].sort()).toEqual(["ended", "new"]);
  });

  it("forgets velocity commands and battery states that are no longer known", () => {
    const state = stateAfter([snapshot(), batteryEvent(), cmdVel(0, 0.15), snapshot()]);
    expect(state.cmdVel.twist).toBeNull();
    expect(state.battery.state).toBeNull();
  });

  it("tells the difference between the clocks, and heartbeats make it better only", () => {
    const skewed = reduce(initialState, snapshot({ time: at(0) }), START + 5000);
    expect(skewed.clockSkew).toBe(5000);
    expect(reduce(skewed, { type: "heartbeat", id: "1", time: at(1) }, START + 5200).clockSkew).toBe(4200);
    expect(reduce(skewed, { type: "heartbeat", id: "1", time: at(1) }, START + 9000).clockSkew).toBe(5000);
  });
});

describe("events of a goal", () => {
  it("lead from acceptance to the result", () => {
    const state = stateAfter([
      snapshot(),
      status("a", { status: "accepted" }),
      status("a", { status: "executing" }),
      feedback("a"),
      feedback("a"),
      status("a", { status: "succeeded", finished_at: at(3), feedback_count: 2 }),
      result("a"),
    ]);
    expect(state.goals.get("a")).toMatchObject({
      status: "succeeded",
      feedback_count: 2,
      finished_at: at(3),
      feedback: { current_battery_state: battery },
      result: { final_battery_state: battery },
    });
  });

  it("count once though they come twice", () => {
    const event = feedback("a");
    const once = stateAfter([status("a"), event]);
    const twice = reduce(once, event, START);
    expect(twice).toBe(once);
    expect(twice.goals.get("a")?.feedback_count).toBe(1);
  });

  it("make an unknown goal known", () => {
    expect(stateAfter([feedback("x")]).goals.get("x")).toMatchObject({
      status: "executing",
      feedback_count: 1,
    });
    expect(stateAfter([result("y")]).goals.get("y")).toMatchObject({
      status: "succeeded",
      finished_at: at(3),
    });
    expect(stateAfter([status("z", { origin: "external" })]).goals.get("z")?.origin).toBe("external");
  });

  it("do not lead back from the end", () => {
    const ended = stateAfter([status("a"), result("a")]);
    for (const late of [status("a", { status: "executing" }), result("a", { status: "aborted" })]) {
      expect(reduce(ended, late, START).goals.get("a")).toMatchObject({ status: "succeeded" });
    }
  });

  it("bring a lost goal to its result after all", () => {
    const lost = stateAfter([
      status("a"),
      status("a", {
        status: "lost",
        finished_at: at(2),
        error: { code: "action_server_lost", detail: "gone" },
      }),
      result("a", { status: "lost", result: null, error: { code: "action_server_lost", detail: "gone" } }),
    ]);
    expect(lost.goals.get("a")).toMatchObject({ status: "lost", error: { code: "action_server_lost" } });
    const back = stateAfter([status("a", { status: "executing" }), result("a", {}, 9)], lost);
    expect(back.goals.get("a")).toMatchObject({ status: "succeeded", error: null, finished_at: at(9) });
  });

  it("say why a goal did not succeed", () => {
    const error = { code: "battery_lost", detail: "no battery for 60 s" };
    const state = stateAfter([status("a"), result("a", { status: "aborted", result: null, error })]);
    expect(state.goals.get("a")).toMatchObject({ status: "aborted", error, result: null });
  });

  it("keep the times of a running goal's feedback, and those only", () => {
    const events = Array.from({ length: 100 }, (_, index) => feedback("a", index));
    const running = stateAfter([status("a"), ...events]);
    expect(running.arrivals.get("a")).toHaveLength(MAX_ARRIVALS);
    expect(stateAfter([result("a")], running).arrivals.size).toBe(0);
  });

  it("feedback ends a stall", () => {
    const state = stateAfter([status("a", { stalled: true }), feedback("a")]);
    expect(state.goals.get("a")?.stalled).toBe(false);
  });
});

describe("other events", () => {
  it("renew the battery, the velocity command, the publisher and the action server", () => {
    const publisher = { ...idlePublisher, active: true, rate_hz: 2, published_count: 7, state: battery };
    const state = stateAfter([
      snapshot(),
      batteryEvent({ percentage: 0.5 }, 4),
      cmdVel(0.1, 0.15, 5),
      { type: "battery_publisher", time: at(6), robot: "/", battery_publisher: publisher },
      { type: "action_server", time: at(6), action_server: { ...server, answering: false } },
    ]);
    expect(state.battery.state?.percentage).toBe(0.5);
    expect(state.battery.receivedAt).toBe(START + 4000);
    expect(state.battery.staleAfterS).toBe(2);
    expect(state.cmdVel.twist?.linear.x).toBe(0.1);
    expect(state.publisher).toEqual(publisher);
    expect(state.actionServer?.answering).toBe(false);
  });

  it("add up what the gateway did not read", () => {
    const lost: GatewayEvent = {
      type: "feedback_dropped",
      time: at(1),
      goal_id: "a",
      action_name: "/dock",
      reason: "feedback_too_large",
      count: 4,
    };
    expect(stateAfter([lost, lost]).unread).toBe(8);
  });

  it("add up what was dropped", () => {
    const dropped = (count: number): GatewayEvent => ({ type: "dropped", time: at(1), count });
    expect(stateAfter([dropped(12), dropped(3)]).dropped).toBe(15);
  });

  it("of a kind that is not known change nothing", () => {
    const unknown = { type: "weather", time: at(1) } as unknown as GatewayEvent;
    expect(reduce(initialState, unknown, START)).toBe(initialState);
  });

  it("leave the parts that they do not touch as they are", () => {
    const before = stateAfter([snapshot({ goals: [goal("a")] })]);
    const next = reduce(before, batteryEvent(), START);
    expect(next.goals).toBe(before.goals);
    expect(next.arrivals).toBe(before.arrivals);
  });
});

describe("a state that an older gateway stored, without a verb", () => {
  const { verb: _verb, ...old } = status("a", { status: "succeeded" });

  it("leaves a goal its verb", () => {
    const state = stateAfter([snapshot({ goals: [goal("a")] }), old as GatewayEvent]);
    expect(state.goals.get("a")).toMatchObject({ status: "succeeded", verb: "dock" });
  });

  it("is told in the words for any action", () => {
    const known = stateAfter([snapshot(), old as GatewayEvent]).goals.get("a");
    expect(known && [meaning(known), outcome(known)]).toEqual(["The goal succeeded.", "Done"]);
  });
});

describe("other actions on the graph", () => {
  const name = "/fibonacci";
  const goalOfOthers = {
    ...goal("f", {
      action_name: name,
      action_type: "action_tutorials_interfaces/action/Fibonacci",
      verb: null,
    }),
    goal: { order: 5 },
    feedback: { partial_sequence: [0, 1, 1] },
  } as unknown as LiveGoal;
  const events = [
    status("f", { action_name: name }),
    { ...feedback("f"), action_name: name, feedback: { partial_sequence: [0, 1, 1] } },
    { ...result("f"), action_name: name, result: { sequence: [0, 1, 1, 2] } },
    { ...feedback("r"), action_name: "/robot1/dock" },
    { type: "action_server", time: at(6), action_server: { ...server, action_name: name, available: false } },
  ] as unknown as GatewayEvent[];

  it("change nothing by their events, and take no room from ours", () => {
    const before = stateAfter([status("a"), feedback("a")]);
    for (const event of events) expect(reduce(before, event, START)).toBe(before);
  });

  it("have goals in the snapshot that are not shown", () => {
    const state = stateAfter([snapshot({ goals: [goalOfOthers, goal("a")] })]);
    expect([...state.goals.keys()]).toEqual(["a"]);
  });

  it("are left behind where the gateway comes back with another one", () => {
    const before = stateAfter([snapshot({ goals: [goal("old", { status: "succeeded" })] })]);
    const moved = { ...server, action_name: "/robot1/dock" };
    const state = stateAfter(
      [snapshot({ docking: { dock: moved, undock: undockServer }, goals: [goal("a")] })],
      before,
    );
    expect(state.goals.size).toBe(0);
    expect(state.actionServer).toEqual(moved);
  });
});

describe("the undocking action", () => {
  const name = "/disconnect_from_charging_dock";

  it("is the one that the snapshot names, and its goals are taken up", () => {
    const undock = { ...server, action_name: "/leave", available: false, answering: false };
    const state = stateAfter([
      snapshot({ docking: { dock: server, undock } }),
      status("u", { action_name: "/leave" }),
    ]);
    expect(state.undockServer).toEqual(undock);
    expect(state.goals.get("u")?.action_name).toBe("/leave");
  });

  it("comes and goes apart from the docking action", () => {
    const action_server = { ...server, action_name: name };
    const state = stateAfter([snapshot(), { type: "action_server", time: at(1), action_server }]);
    expect(state.undockServer).toEqual(action_server);
    expect(state.actionServer).toEqual(server);
  });
});

describe("another docking action", () => {
  const nav2 = { ...server, action_name: "/dock_robot", action_type: "nav2_msgs/action/DockRobot" };
  const docking = { dock: nav2, undock: { ...nav2, action_name: "/undock_robot" } };
  const switched: GatewayEvent = { type: "docking", time: at(2), robot: "/", docking };

  it("takes the place of the one before, whose goals stay", () => {
    const state = stateAfter([
      snapshot({ goals: [goal("a")] }),
      switched,
      status("b", { action_name: "/dock_robot" }),
      status("a", { status: "succeeded" }),
    ]);
    expect([state.actionServer, state.undockServer]).toEqual([docking.dock, docking.undock]);
    expect(state.goals.get("b")?.action_name).toBe("/dock_robot");
    expect(state.goals.get("a")?.status).toBe("succeeded");
  });
});

const way = (state: State) => state.stages.get("a")?.map(({ stage }) => stage);

describe("feedback", () => {
  it("is remembered as it comes, the newest first, and not for ever", () => {
    const events = Array.from({ length: 30 }, (_, index) => feedback("a", index));
    const state = stateAfter([snapshot(), ...events]);
    expect(state.feedback).toHaveLength(MAX_FEEDBACK);
    expect(state.feedback[0]).toEqual(events.at(-1));
  });
});

describe("the stages of a goal", () => {
  it("are remembered in order, each once, without those of the end", () => {
    const stages = ["INITIAL_PERCEPTION", "CONTROLLING", "CONTROLLING", "RETRY", "CONTROLLING", "ABORTED"];
    const state = stateAfter([snapshot(), ...stages.map((stage) => status("a", { stage }))]);
    expect(way(state)).toEqual(["INITIAL_PERCEPTION", "CONTROLLING", "RETRY", "CONTROLLING"]);
    expect(state.stages.get("a")?.[0]?.since).toBe(START + 1000);
  });

  it("begin with that of the snapshot", () => {
    const state = stateAfter([snapshot({ goals: [goal("a", { stage: "CONTROLLING" })] })]);
    expect(state.stages.get("a")).toEqual([{ stage: "CONTROLLING", since: null }]);
  });
});

describe("stop and simulator", () => {
  it("are as the last event says", () => {
    const stop = { type: "stop", id: null, time: at(1), robot: "/", stop: latched("Ada") } as const;
    const told = { type: "simulator", time: at(1), robot: "/", simulator } as const;
    const state = stateAfter([snapshot(), stop, told]);
    expect(state.stop).toEqual(latched("Ada"));
    expect(state.simulator).toEqual(simulator);
    const gone = { ...told, simulator: { ...simulator, available: false } };
    expect(stateAfter([gone], state).simulator).toBeNull();
  });

  it("are not known from before the connection was lost", () => {
    const told = { type: "simulator", time: at(1), robot: "/", simulator } as const;
    expect(stateAfter([snapshot(), told, snapshot()]).simulator).toBeNull();
  });
});

describe("memory", () => {
  it("holds a bounded number of goals, without the oldest ended ones", () => {
    const events = Array.from({ length: MAX_GOALS + 50 }, (_, index) =>
      status(`g${index}`, { status: "succeeded", created_at: at(index) }, index),
    );
    const state = stateAfter([status("runs", { created_at: at(-100) }), ...events]);
    expect(state.goals.size).toBe(MAX_GOALS);
    expect(state.goals.has("runs")).toBe(true);
    expect(state.goals.has("g0")).toBe(false);
    expect(newestFirst(state.goals)[0]?.goal_id).toBe(`g${MAX_GOALS + 49}`);
  });

  it("holds a bounded number of event ids", () => {
    const state = stateAfter(Array.from({ length: MAX_SEEN + 100 }, (_, index) => batteryEvent({}, index)));
    expect(state.seen.size).toBe(MAX_SEEN);
  });
});

describe("goals from an answer over HTTP", () => {
  it("are taken up where they are new", () => {
    expect(mergeGoals(initialState, [goal("a"), goal("b")]).goals.size).toBe(2);
  });

  it("do not undo what events have told", () => {
    const state = stateAfter([status("a", { status: "executing" }, 5), result("a", {}, 6)]);
    const merged = mergeGoals(state, [goal("a", { status: "canceling", updated_at: at(9) })]);
    expect(merged.goals.get("a")?.status).toBe("succeeded");
    const older = mergeGoals(stateAfter([status("b", { status: "executing" }, 5)]), [
      goal("b", { status: "accepted", updated_at: at(4) }),
    ]);
    expect(older.goals.get("b")?.status).toBe("executing");
  });
});
