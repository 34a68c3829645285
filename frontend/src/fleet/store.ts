import type { Alert, GatewayEvent, StopState } from "../api/types";
import { steadyNow } from "../clock/beat";
import { StreamStore } from "../store/streamStore";
import type { Connection } from "../stream/connection";
import { reduceFleet, withStop } from "./reducer";
import { type FleetState, type FleetTopics, initialFleet } from "./state";

function topicsOf(
  { seen: _seen, resumed: _resumed, ...state }: FleetState,
  connection: Connection,
): FleetTopics {
  return { ...state, connection };
}

/** Holds what is known of all robots. */
export class FleetStore extends StreamStore<FleetState, FleetTopics> {
  constructor(now: () => number = steadyNow) {
    super(initialFleet, reduceFleet, topicsOf, now);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    if (!this.take(event)) return;
    // The page's title counts them, also where nobody sees the rest of the page.
    if (event.type === "alerts") this.shown.flush();
    else this.shown.schedule();
  };

  /** Takes up what an answer over HTTP says of a robot's stop, the configured one for null: people wait for it. */
  setStop(stop: StopState, robot: string | null = null): void {
    this.state = withStop(this.state, robot, stop);
    this.shown.flush();
  }

  /** Takes up what an answer over HTTP says of an alert: at once, as people wait for it. */
  setAlert(alert: Alert): void {
    const alerts = this.state.alerts.map((known) => (known.id === alert.id ? alert : known));
    this.state = { ...this.state, alerts };
    this.shown.flush();
  }
}
