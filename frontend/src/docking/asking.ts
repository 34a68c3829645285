import { useLocalStorage } from "@mantine/hooks";
import { useTopicPart } from "../store/context";

const KEY = "dock-gateway-ask-before-moving";

export interface Asking {
  /** Whether a click that makes the robot move is asked about. */
  asks: boolean;
  /** Nobody is hurt by a simulated robot: it is never asked about. */
  simulated: boolean;
  change: (asks: boolean) => void;
}

/** Whether this browser asks before a real robot moves. */
export function useAskingWanted() {
  return useLocalStorage({ key: KEY, defaultValue: true, getInitialValueInEffect: false });
}

/** Whether to ask before this robot moves: a real one, until somebody switches that off in this browser. */
export function useAsking(): Asking {
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const [wanted, change] = useAskingWanted();
  return { asks: wanted && !simulated, simulated, change };
}
