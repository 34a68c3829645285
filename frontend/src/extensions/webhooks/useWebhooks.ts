import { useQueryClient } from "@tanstack/react-query";
import { useForbidden } from "../../api/session";
import type { Base } from "../../api/version";
import { useFleet, useFleetLive } from "../../fleet/context";
import type { Naming } from "../../fleet/names";
import { useAnswer, useCommand } from "../../ui/requests";
import { formatTime } from "../../ui/time";
import {
  type Delivery,
  deleteWebhook,
  listDeliveries,
  listWebhooks,
  putWebhook,
  type StoredWebhook,
  testWebhook,
  type Webhook,
  type WebhookBody,
} from "./requests";

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
  const save = useCommand(
    ({ id, body, base }: { id: string; body: WebhookBody; base: Base }): Promise<StoredWebhook> =>
      putWebhook(http, id, body, base).finally(changed),
  );
  const remove = useCommand((webhook: Webhook) => deleteWebhook(http, webhook).finally(changed));
  const test = useCommand(async (id: string) => {
    const delivery = await testWebhook(http, id);
    void client.invalidateQueries({ queryKey: [...KEY, id] });
    void changed();
    return delivery;
  });
  return { save, remove, test };
}

export function severityWords({ severities }: Pick<Webhook, "severities">): string {
  return severities.includes("warning") ? "All alerts" : "Critical alerts only";
}

export const EVENTS: Record<Delivery["type"], string> = {
  "alert.raised": "Began",
  "alert.cleared": "Ended",
  test: "Sent by hand",
};

/** `Stopped, Left forklift`, `History lost` */
export function alertWords({ event: { data } }: Pick<Delivery, "event">, naming: Naming): string {
  if (!("title" in data)) return "Test";
  return data.robot === null ? data.title : `${data.title}, ${naming.nameOf(data.robot)}`;
}

export const STATES: Record<Delivery["state"], { words: string; color: string }> = {
  delivered: { words: "Delivered", color: "gray" },
  pending: { words: "Pending", color: "orange" },
  failed: { words: "Failed", color: "red" },
};

/** `204`, `The answer was 503, third attempt. Next at 17:02:11` */
export function outcomeWords({ state, status_code, error, attempts, next_at }: Delivery): string {
  if (state === "delivered") return attempts > 1 ? `${status_code}, attempt ${attempts}` : `${status_code}`;
  const tried =
    error === null ? "" : `${error.charAt(0).toUpperCase()}${error.slice(1)}, attempt ${attempts}`;
  const next = next_at === null || attempts === 0 ? "" : `Next at ${formatTime(Date.parse(next_at))}`;
  return [tried, next].filter((words) => words !== "").join(". ");
}

/** What came of a test, in a sentence. */
export function testWords({ state, status_code, error }: Delivery): string {
  return state === "delivered" ? `The test was delivered: the answer was ${status_code}.` : `${error}`;
}
