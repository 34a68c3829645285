import { useQueryClient } from "@tanstack/react-query";
import { useForbidden } from "../api/permissions";
import {
  deleteWebhook,
  listDeliveries,
  listWebhooks,
  putWebhook,
  type StoredWebhook,
  testWebhook,
  type WebhookBody,
} from "../api/webhooks";
import { useFleet, useFleetLive } from "../fleet/context";
import { useAnswer, useCommand } from "../ui/requests";

const KEY = ["webhooks"] as const;
/** How often it is asked what was sent, and what others have changed (ms). */
const REFETCH_MS = 5000;

/** The webhooks, as they are now. */
export function useWebhooks() {
  const { http } = useFleet();
  return useAnswer({
    queryKey: KEY,
    queryFn: () => listWebhooks(http),
    enabled: useEnabled(),
    refetchInterval: REFETCH_MS,
  });
}

/** Whether they can be asked for. */
function useEnabled(): boolean {
  const live = useFleetLive();
  return useForbidden("GET /webhooks") === null && live;
}

/** What was and is to be sent to a webhook. */
export function useDeliveries(id: string) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: [...KEY, id, "deliveries"],
    queryFn: () => listDeliveries(http, id),
    enabled: useEnabled(),
    refetchInterval: REFETCH_MS,
  });
}

/** What changes webhooks, and tries them out. */
export function useWebhookCommands() {
  const { http } = useFleet();
  const client = useQueryClient();
  // Not the deliveries: those of a webhook that was removed are gone.
  const changed = () => client.invalidateQueries({ queryKey: KEY, exact: true });
  const save = useCommand(async ({ id, body }: { id: string; body: WebhookBody }): Promise<StoredWebhook> => {
    const stored = await putWebhook(http, id, body);
    await changed();
    return stored;
  });
  const remove = useCommand(async (id: string) => {
    await deleteWebhook(http, id);
    await changed();
  });
  const test = useCommand(async (id: string) => {
    const delivery = await testWebhook(http, id);
    void client.invalidateQueries({ queryKey: [...KEY, id] });
    void changed();
    return delivery;
  });
  return { save, remove, test };
}
