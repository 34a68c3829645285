import {
  type Alert,
  type BatteryStateInput,
  type Calibration,
  type CalibrationService,
  type components,
  type DockList,
  deadline,
  type Http,
  type LiveGoal,
  newKey,
  type Publisher,
  type paths,
  type StopReport,
  type StopState,
  settle,
} from "@dock-gateway/client";

/** The gateway waits up to 18 s for the docking server. */
const CALIBRATION_TIMEOUT_MS = 25_000;

/**
 * What can be asked of a robot. Each call is one HTTP request: nothing is sent again by itself, because a command
 * that arrives late is worse than one that fails. Every failure is a ClientError.
 *
 * @param robot The robot's namespace; null for the one that the gateway is configured for. A stop and its release name theirs.
 */
export function createGateway(http: Http, robot: string | null = null) {
  const query = robot === null ? {} : { robot };
  const options = () => ({ params: { query }, signal: deadline() });
  const goalOptions = () => ({
    params: { query, header: { "Idempotency-Key": newKey() } },
    signal: deadline(),
  });

  return {
    /**
     * @param desiredStatus How its battery is to be; null where the docking server has no such goals.
     * @param dockId The name of the dock; the default one without it.
     */
    dock: (desiredStatus: number | null, dockId?: string): Promise<LiveGoal> => {
      const body = {
        ...(desiredStatus !== null && { desired_battery_state: { power_supply_status: desiredStatus } }),
        ...(dockId !== undefined && { dock_id: dockId }),
      };
      return settle(http.POST("/dock", { ...(Object.keys(body).length > 0 && { body }), ...goalOptions() }));
    },
    /** The docks that the docking server knows by name. */
    docks: (): Promise<DockList> => settle(http.GET("/docks", options())),
    undock: (): Promise<LiveGoal> => settle(http.POST("/undock", goalOptions())),
    cancel: async (goalId: string) =>
      (await settle(
        http.POST("/goals/{goal_id}/cancel", { params: { path: { goal_id: goalId } }, signal: deadline() }),
      )) as LiveGoal,
    /** Stops robots until `release`, with one request; all of them for an empty list. */
    stop: (by: string, robots: readonly string[]): Promise<StopReport> =>
      settle(
        http.POST("/stop", { body: { by }, params: { query: { robot: [...robots] } }, signal: deadline() }),
      ),
    /** Releases the stop of a robot and of those below it. */
    release: (stopped: string): Promise<StopState> =>
      settle(http.DELETE("/stop", { params: { query: { robot: stopped } }, signal: deadline() })),
    publishOnce: async (state: BatteryStateInput) => {
      await settle(http.POST("/battery", { body: state, ...options() }));
    },
    publishRepeatedly: (state: BatteryStateInput, rateHz: number): Promise<Publisher> =>
      settle(http.PUT("/battery/publisher", { body: { state, rate_hz: rateHz }, ...options() })),
    stopPublishing: async () => {
      await settle(http.DELETE("/battery/publisher", options()));
    },
    calibrationService: (): Promise<CalibrationService> => settle(http.GET("/calibration", options())),
    /** Measures where the docked robot stands, which takes seconds. */
    calibrate: (): Promise<Calibration> =>
      settle(http.POST("/calibration", { params: { query }, signal: deadline(CALIBRATION_TIMEOUT_MS) })),
  };
}

export type Gateway = ReturnType<typeof createGateway>;

/** What can be done about alerts; each call is one request, and every failure a ClientError. */
export function createAlerts(http: Http) {
  const options = (id: string) => ({ params: { path: { alert_id: id } }, signal: deadline() });
  return {
    /** Says that somebody has seen it, until it ends. */
    acknowledge: (id: string, by: string): Promise<Alert> =>
      settle(http.PUT("/alerts/{alert_id}/acknowledgement", { body: { by }, ...options(id) })),
    withdraw: async (id: string): Promise<void> => {
      await settle(http.DELETE("/alerts/{alert_id}/acknowledgement", options(id)));
    },
  };
}

type LabelBody = NonNullable<paths["/label"]["put"]["requestBody"]>["content"]["application/json"];

export type Label = components["schemas"]["Label"];

/** The display name and the groups of a robot; throws a ClientError where it fails. */
export function getLabel(http: Http, robot: string): Promise<Label> {
  return settle(http.GET("/label", { params: { query: { robot } }, signal: deadline() }));
}

/** Replaces a label, unless someone else has changed it meanwhile; throws a ClientError where it fails. */
export function putLabel(http: Http, { robot, etag }: Label, body: LabelBody): Promise<Label> {
  const params = { query: { robot }, header: { "If-Match": etag } };
  return settle(http.PUT("/label", { params, body, signal: deadline() }));
}
