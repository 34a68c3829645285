import { useFleet, useFleetLive } from "../../../fleet/context";
import { useAnswer } from "../../../ui/requests";
import { listPlaces, type Place } from "./requests";

export const PLACES = ["places"] as const;

/** The places that missions drive to. */
export function usePlaces() {
  const { http } = useFleet();
  return useAnswer({ queryKey: PLACES, queryFn: () => listPlaces(http), enabled: useFleetLive() });
}

/** What a place is called: its name, else its id. */
export function placeName({ id, name }: Pick<Place, "id" | "name">): string {
  return name ?? id;
}
