import { Text } from "@mantine/core";
import { useEffect } from "react";
import { useForbidden } from "../../api/session";
import type { Places } from "../../extension/extension";
import { useFreshness, useScene, useServices, useTopicPart } from "../../store/context";
import { fixed } from "../../ui/numbers";
import { useSimulatorApi } from "./requests";

/** Places a simulated robot, and says where its time passes more slowly than it should. */
export function SimulatedPlacing({ onPlacing }: Places["placing"]) {
  const { place } = useSimulatorApi();
  useSimulatorAsked();
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const forbidden = useForbidden("POST /simulator/place");
  useEffect(() => {
    if (!simulated) return;
    onPlacing({ place, forbidden });
    return () => onPlacing(null);
  }, [simulated, place, forbidden, onPlacing]);
  const speed = useTopicPart("simulator", (simulator) =>
    simulator?.too_slow === true ? simulator.real_time_factor : null,
  );
  return speed === null ? null : (
    <Text size="sm" role="status" p="xs" bg="body">
      The machine is too slow for the simulation, whose time runs at {fixed(speed, 2)} of real time:
      everything takes longer.
    </Text>
  );
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
