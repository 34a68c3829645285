import type {
  ActionInfo,
  ActionServer,
  Alert,
  Battery,
  BatteryState,
  EventOf,
  LiveGoal,
  Publisher,
  Robot,
  Scene,
  Simulator,
  StopReport,
  StopState,
} from "@dock-gateway/client";

export const START = Date.parse("2026-11-21T03:32:40Z");

export function at(seconds: number): string {
  return new Date(START + seconds * 1000).toISOString();
}

export const battery: BatteryState = {
  header: { stamp: { sec: 0, nanosec: 0 }, frame_id: "" },
  voltage: 2.16,
  temperature: null,
  current: null,
  charge: null,
  capacity: null,
  design_capacity: null,
  percentage: 0.24,
  power_supply_status: 3,
  power_supply_health: 0,
  power_supply_technology: 0,
  present: false,
  cell_voltage: [],
  cell_temperature: [],
  location: "",
  serial_number: "",
};

export const idlePublisher: Publisher = {
  active: false,
  state: null,
  rate_hz: null,
  published_count: 0,
  started_at: null,
};

export const server: ActionServer = {
  action_name: "/dock",
  action_type: "action_tutorials_interfaces/action/ConnectToChargingDock",
  available: true,
  answering: true,
  duplicate: false,
};

export const undockServer: ActionServer = {
  action_name: "/disconnect_from_charging_dock",
  action_type: "action_tutorials_interfaces/action/DisconnectFromChargingDock",
  available: true,
  answering: true,
  duplicate: false,
};

export const released: StopState = {
  latched: false,
  stopped_at: null,
  by: null,
  robots: [],
  persisted: true,
};

export function latched(by: string | null, seconds = 0): StopState {
  return { latched: true, stopped_at: at(seconds), by, robots: ["/"], persisted: true };
}

/** All robots, as the report of a stop shows them. */
export function latchedStops(by: string | null): StopReport["stop"] {
  const stop = latched(by);
  return { ...stop, for_all: true, stops: [{ robot: "/", stopped_at: stop.stopped_at ?? "", by }] };
}

export function stopReport(change: Partial<StopReport> = {}): StopReport {
  return {
    stopped: ["/"],
    not_stopped: [],
    canceling: [],
    failed: [],
    unconfirmed: [],
    stop: latchedStops("the dashboard"),
    others: [],
    warning: null,
    ...change,
  };
}

export function undockGoal(id: string, change: Partial<LiveGoal> = {}): LiveGoal {
  const action_type = "action_tutorials_interfaces/action/DisconnectFromChargingDock";
  return goal(id, { action_name: undockServer.action_name, action_type, verb: "undock", ...change });
}

/** A battery with a state, which is believed. */
export function batteryDocument(state: BatteryState | null, change: Partial<Battery> = {}): Battery {
  return {
    state,
    percentage: state?.percentage ?? null,
    implausible: [],
    received_at: state === null ? null : at(0),
    stale: false,
    stale_after_s: 2,
    low_below: 0.2,
    ...change,
  };
}

export function robot(name: string, change: Partial<Robot> = {}): Robot {
  const action = (verb: string): ActionServer => ({
    action_name: `${name === "/" ? "" : name}/${verb}`,
    action_type: (verb === "dock" ? server : undockServer).action_type,
    available: true,
    answering: true,
    duplicate: false,
  });
  return {
    name,
    display_name: null,
    groups: [],
    default: name === "/",
    docked: false,
    simulated: false,
    charging: null,
    battery: batteryDocument(battery, { received_at: new Date().toISOString() }),
    battery_topic: `${name === "/" ? "" : name}/battery_status`,
    battery_publisher: { active: false, rate_hz: null },
    stop: released,
    dock: action("dock"),
    undock: action("undock"),
    join: null,
    goals: [],
    last_goal: null,
    ...change,
  };
}

export function fibonacciAction(name: string): ActionInfo {
  return {
    action_name: name,
    action_type: "action_tutorials_interfaces/action/Fibonacci",
    verb: null,
    available: true,
    answering: true,
    duplicate: false,
    installed: true,
    hint: null,
    running_goals: 0,
    feedback_dropped: 0,
    unknown_goals_ignored: 0,
  };
}

export function alert(id: string, change: Partial<Alert> = {}): Alert {
  return {
    id,
    etag: `"${id}"`,
    kind: "low_battery",
    robot: "/robot1",
    severity: "warning",
    started_at: at(0),
    title: "Low battery",
    detail: "12 % and no docking goal runs: dock it.",
    goal_id: null,
    acknowledged: null,
    ...change,
  };
}

export function goal(id: string, change: Partial<LiveGoal> = {}): LiveGoal {
  return {
    goal_id: id,
    action_name: "/dock",
    action_type: "action_tutorials_interfaces/action/ConnectToChargingDock",
    verb: "dock",
    status: "executing",
    stalled: false,
    stage: null,
    retries: null,
    origin: "gateway",
    goal: null,
    feedback: null,
    result: null,
    error: null,
    created_at: at(0),
    updated_at: at(0),
    finished_at: null,
    feedback_count: 0,
    last_event_id: null,
    ...change,
  };
}

export function snapshot(change: Partial<EventOf<"snapshot">> = {}): EventOf<"snapshot"> {
  return {
    type: "snapshot",
    id: "00000000000000000000-s-none",
    time: at(0),
    goals: [],
    battery: batteryDocument(null),
    battery_publisher: idlePublisher,
    docking: { dock: server, undock: undockServer },
    stop: released,
    ...change,
  };
}

let serial = 0;
/** The next event id; ids sort as text. */
function nextId(): string {
  serial += 1;
  return `e${String(serial).padStart(6, "0")}`;
}

function head(id: string, seconds: number) {
  return { id: nextId(), time: at(seconds), goal_id: id, action_name: "/dock" };
}

export function status(id: string, change: Partial<LiveGoal> = {}, seconds = 1): EventOf<"status"> {
  const {
    feedback: _feedback,
    result: _result,
    ...summary
  } = goal(id, { updated_at: at(seconds), ...change });
  return { ...head(id, seconds), ...summary, type: "status" };
}

export function feedback(id: string, seconds = 2): EventOf<"feedback"> {
  return { ...head(id, seconds), type: "feedback", feedback: { current_battery_state: battery } };
}

export function result(id: string, change: Partial<EventOf<"result">> = {}, seconds = 3): EventOf<"result"> {
  return {
    ...head(id, seconds),
    type: "result",
    status: "succeeded",
    result: { final_battery_state: battery },
    error: null,
    ...change,
  };
}

export function batteryEvent(change: Partial<BatteryState> = {}, seconds = 1): EventOf<"battery"> {
  return {
    type: "battery",
    id: nextId(),
    time: at(seconds),
    robot: "/",
    battery: batteryDocument({ ...battery, ...change }, { received_at: at(seconds) }),
  };
}

export function cmdVel(x: number, turn: number, seconds = 1): EventOf<"cmd_vel"> {
  const zero = { x: 0, y: 0, z: 0 };
  return {
    type: "cmd_vel",
    id: nextId(),
    time: at(seconds),
    robot: "/",
    cmd_vel: { linear: { ...zero, x }, angular: { ...zero, z: turn } },
  };
}

export const emptyScene: Scene = {
  frame: "world",
  robot: { x: -1.5, y: 0.4, theta: -0.3 },
  odom: null,
  dock: { x: 0, y: 0, theta: 0 },
  docked: null,
  staging: null,
  marker: null,
  infrared: null,
  footprint: null,
};

export function sceneEvent(change: Partial<Scene> = {}, seconds = 1): EventOf<"scene"> {
  return { type: "scene", time: at(seconds), robot: "/", scene: { ...emptyScene, ...change } };
}

export const simulator: Simulator = {
  available: true,
  faults: { dead_charger: false, occluded_marker: false, stuck_wheel: true },
  contact: false,
  docked: false,
  battery_publisher: "self",
  real_time_factor: 1,
  too_slow: false,
  places: [],
};
