import { useQueryClient } from "@tanstack/react-query";
import { useCallback, useEffect } from "react";
import type { Base } from "../../api/version";
import { useFleet, useFleetEvent, useFleetLive } from "../../fleet/context";
import { useAnswer, useCommand } from "../../ui/requests";
import {
  type DockBody,
  type DockReport,
  deleteDock,
  listDocks,
  putDock,
  reportDock,
  type SharedDock,
} from "./requests";

const KEY = ["shared-docks"] as const;

/** The shared docks, as they are now. */
export function useDocks() {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const renew = useCallback(() => void client.invalidateQueries({ queryKey: KEY }), [client]);
  useFleetEvent("shared_dock", renew);
  useEffect(() => {
    if (live) renew();
  }, [live, renew]);
  return useAnswer({ queryKey: KEY, queryFn: () => listDocks(http), enabled: live });
}

/** What changes docks, and says what is seen there. */
export function useDockCommands() {
  const { http } = useFleet();
  const client = useQueryClient();
  const changed = () => client.invalidateQueries({ queryKey: KEY });
  const save = useCommand(({ id, body, base }: { id: string; body: DockBody; base: Base }) =>
    putDock(http, id, body, base).finally(changed),
  );
  const remove = useCommand((dock: SharedDock) => deleteDock(http, dock).finally(changed));
  const report = useCommand(({ id, body }: { id: string; body: DockReport }) =>
    reportDock(http, id, body).finally(changed),
  );
  return { save, remove, report };
}
