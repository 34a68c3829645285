import {
  ClientError,
  deadline,
  type Http,
  type Pose,
  type paths,
  type Simulator,
  settle,
} from "@dock-gateway/client";
import { useEffect, useMemo } from "react";
import { useFleet } from "../../fleet/context";
import { useFreshness, useScene, useServices } from "../../store/context";

export type Fault = paths["/simulator/faults/{fault}"]["put"]["parameters"]["path"]["fault"];

/**
 * What can be asked of a robot's simulator; each call is one request, and every failure a ClientError.
 *
 * @param robot The robot's namespace; null for the one that the gateway is configured for.
 */
export function createSimulatorApi(http: Http, robot: string | null) {
  const query = robot === null ? {} : { robot };
  const options = () => ({ params: { query }, signal: deadline() });
  return {
    /** Null where there is no simulator. */
    get: (): Promise<Simulator | null> =>
      settle<Simulator>(http.GET("/simulator", options())).catch((error: unknown) => {
        if (error instanceof ClientError && error.code === "simulator_not_found") return null;
        throw error;
      }),
    reset: async () => {
      await settle(http.POST("/simulator/reset", options()));
    },
    place: async (pose: Pose) => {
      await settle(http.POST("/simulator/place", { body: pose, ...options() }));
    },
    switchFault: async (fault: Fault, active: boolean) => {
      await settle(
        http.PUT("/simulator/faults/{fault}", {
          params: { path: { fault }, query },
          body: { active },
          signal: deadline(),
        }),
      );
    },
  };
}

/** The simulator of the page's robot. */
export function useSimulatorApi() {
  const { http } = useFleet();
  const { robot } = useServices();
  return useMemo(() => createSimulatorApi(http, robot), [http, robot]);
}

/**
 * Asks for the simulator whenever the page reconnects or the scene stops or goes on; events tell of what changes later.
 * It is asked for where there is a true pose, which has no other source.
 */
export function useSimulatorAsked(): void {
  const { get } = useSimulatorApi();
  const { store } = useServices();
  const freshness = useFreshness("scene");
  const simulated = useScene((scene) => scene?.frame === "world");
  useEffect(() => {
    if (!simulated || freshness === "offline") return;
    let wanted = true;
    // Without an answer it is as before; what is wrong with the connection is said at the top.
    get()
      .then((simulator) => wanted && store.setSimulator(simulator))
      .catch(() => {});
    return () => {
      wanted = false;
    };
  }, [get, store, freshness, simulated]);
}
