import { keepPreviousData } from "@tanstack/react-query";
import { useEffect } from "react";
import { fetchStatistics } from "../api/statistics";
import { useFleet, useFleetLive } from "../fleet/context";
import { useAnswer } from "../ui/requests";
import { useZone } from "../ui/zone";
import { isTooLong, toQuery, type View, writeView } from "./view";

const EVERY_MS = 60_000;

/** How goals ended; asked for again every minute, and when the gateway is back. */
export function useStatistics(view: View) {
  const { http, store } = useFleet();
  const live = useFleetLive();
  const zone = useZone();
  const tooLong = isTooLong(view, store.gatewayNow());
  const possible = !tooLong;
  const query = useAnswer({
    queryKey: ["statistics", zone, writeView(view).toString()],
    queryFn: ({ signal }) => fetchStatistics(http, toQuery(view, store.gatewayNow()), signal),
    enabled: possible,
    placeholderData: keepPreviousData,
    refetchInterval: live ? EVERY_MS : false,
  });
  const { refetch } = query;
  useEffect(() => {
    if (live && possible) void refetch({ cancelRefetch: false });
  }, [live, possible, refetch]);
  return { ...query, live, tooLong };
}
