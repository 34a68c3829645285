import {
  ClientError,
  deadline,
  type Http,
  type Pose,
  type paths,
  type Simulator,
  settle,
} from "@dock-gateway/client";
import { useMemo } from "react";
import { useFleet } from "../../fleet/context";
import { useServices } from "../../store/context";

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
