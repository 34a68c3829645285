import { useEffect, useState } from "react";
import { batteryHistory } from "../api/battery";
import { type CommandError, toCommandError } from "../api/errors";
import { useFleet } from "../fleet/context";
import { noPoints, type Points } from "../store/batterySeries";
import { useLive, useServices } from "../store/context";
import { fromHistory } from "./points";
import { edges, type View } from "./view";

const POINTS = 600;
/** A hand that turns the wheel asks once. */
const CALM_MS = 150;
/** What follows now is read again so often at most (s); what came meanwhile was heard live. */
const RENEW_S = { least: 10, most: 240 };

export interface Past {
  points: Points;
  /** How far apart its points are at least (s). */
  resolutionS: number;
  loading: boolean;
  error: CommandError | null;
}

/** What the gateway has kept of the part of time that is shown; read again when the gateway is back. */
export function usePast(view: View): Past {
  const { http } = useFleet();
  const { robot, store } = useServices();
  const live = useLive();
  const [past, setPast] = useState<Past>({ points: noPoints(), resolutionS: 0, loading: true, error: null });

  useEffect(() => {
    if (!live) return;
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout>;
    const read = async () => {
      const { from, to } = edges(view, store.gatewayNow() / 1000);
      try {
        const span = { since: from * 1000, until: to * 1000 + 1, points: POINTS };
        const history = await batteryHistory(http, robot, span, abort.signal);
        if (abort.signal.aborted) return;
        setPast({
          points: fromHistory(history),
          resolutionS: history.resolution_s,
          loading: false,
          error: null,
        });
      } catch (error) {
        if (abort.signal.aborted) return;
        setPast((before) => ({ ...before, loading: false, error: toCommandError(error) }));
      }
      if (view.endS === null) {
        const renewS = Math.min(RENEW_S.most, Math.max(RENEW_S.least, view.spanS / 100));
        timer = setTimeout(read, renewS * 1000);
      }
    };
    setPast((before) => ({ ...before, loading: true }));
    timer = setTimeout(read, CALM_MS);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [http, robot, store, live, view]);

  return past;
}
