import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../api/version";

type Schemas = components["schemas"];

/** An address that receives alerts. */
export type Webhook = Schemas["Webhook"];
/** What a client says of a webhook. */
export type WebhookBody =
  paths["/webhooks/{webhook_id}"]["put"]["requestBody"]["content"]["application/json"];
/** A webhook that was stored, with the secret that was made for it, if one was. */
export type StoredWebhook = Schemas["StoredWebhook"];
/** One event for one webhook. */
export type Delivery = Schemas["Delivery"];

/** A test is answered after ten seconds at most (ms). */
const TEST_MS = 15_000;

export async function listWebhooks(http: Http): Promise<Webhook[]> {
  return (await settle(http.GET("/webhooks", { signal: deadline() }))).webhooks;
}

/** @param base The webhook that it replaces, as it was read. */
export function putWebhook(http: Http, id: string, body: WebhookBody, base: Base): Promise<StoredWebhook> {
  const params = { path: { webhook_id: id }, header: ifUnchanged(base) };
  return settle(http.PUT("/webhooks/{webhook_id}", { params, body, signal: deadline() }));
}

export async function deleteWebhook(http: Http, webhook: Webhook): Promise<void> {
  const params = { path: { webhook_id: webhook.id }, header: ifUnchanged(webhook) };
  await settle(http.DELETE("/webhooks/{webhook_id}", { params, signal: deadline() }));
}

export function testWebhook(http: Http, id: string): Promise<Delivery> {
  const params = { path: { webhook_id: id } };
  return settle(http.POST("/webhooks/{webhook_id}/test", { params, signal: AbortSignal.timeout(TEST_MS) }));
}

/** The newest first. */
export async function listDeliveries(http: Http, id: string): Promise<Delivery[]> {
  const params = { path: { webhook_id: id }, query: { limit: 50 } };
  return (await settle(http.GET("/webhooks/{webhook_id}/deliveries", { params, signal: deadline() })))
    .deliveries;
}
