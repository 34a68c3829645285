import { type Command, useForbidden } from "../api/permissions";
import { useFleetLive } from "./context";

export const NOT_CONNECTED = "The gateway is not connected.";

/**
 * Why a command cannot be given now, in a sentence; null where it can.
 *
 * @param ready Whether what the command needs to know has come.
 */
export function useWhyNot(command: Command, ready = true): string | null {
  const forbidden = useForbidden(command);
  const live = useFleetLive();
  return forbidden ?? (live && ready ? null : NOT_CONNECTED);
}
