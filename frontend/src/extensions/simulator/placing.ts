import { useEffect } from "react";
import { useForbidden } from "../../api/session";
import type { Places } from "../../extension/extension";
import { useTopicPart } from "../../store/context";
import { useSimulatorApi, useSimulatorAsked } from "./requests";

/** Places a simulated robot. */
export function SimulatedPlacing({ onPlacing }: Places["placing"]): null {
  const { place } = useSimulatorApi();
  useSimulatorAsked();
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const forbidden = useForbidden("POST /simulator/place");
  useEffect(() => {
    if (!simulated) return;
    onPlacing({ place, forbidden });
    return () => onPlacing(null);
  }, [simulated, place, forbidden, onPlacing]);
  return null;
}
