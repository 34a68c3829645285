import type { Alert } from "@dock-gateway/client";
import { screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import type { Delivery, Webhook, WebhookBody } from "../../../src/extensions/webhooks/requests";
import { outcomeWords, testWords } from "../../../src/extensions/webhooks/useWebhooks";
import { bodyOf, draftOf, errorsOf, switched } from "../../../src/extensions/webhooks/WebhookForm";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/webhooks/Webhooks";
import "../../../src/notifications/NotificationsPage";
import { fakeGateway, renderPage } from "../../page";

const LOW: Alert = {
  id: "low",
  etag: '"1"',
  kind: "low_battery",
  robot: "/robot1",
  severity: "warning",
  started_at: "2026-11-23T10:00:00Z",
  title: "Low battery",
  detail: "Send the robot to its dock.",
  goal_id: null,
  acknowledged: null,
};
const SENT: Delivery = {
  id: "d1",
  webhook_id: "room",
  type: "alert.raised",
  created_at: "2026-11-23T10:00:00Z",
  event: {
    type: "alert.raised",
    timestamp: "2026-11-23T10:00:00Z",
    text: "Low battery",
    data: { ...LOW, display_name: null, groups: [] },
  },
  state: "delivered",
  attempts: 1,
  next_at: null,
  tried_at: "2026-11-23T10:00:01Z",
  status_code: 204,
  error: null,
};
const ROOM: Webhook = {
  id: "room",
  etag: '"1"',
  name: "Control room",
  url: "https://hooks.example.com/a",
  enabled: true,
  severities: ["critical", "warning"],
  robots: { all: true, names: [], groups: [] },
  changed_by: "Ada",
  changed_at: "2026-11-23T09:00:00Z",
  pending: 0,
  last_delivery: null,
};

/** A gateway with these webhooks; it remembers what it is asked. */
function answering(webhooks: Webhook[], tested: Delivery = { ...SENT, type: "test" }) {
  const asked: { method: string; path: string; body: WebhookBody | null }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const { pathname } = new URL(request.url);
    const { method } = request;
    if (pathname === "/webhooks") return Response.json({ webhooks });
    if (pathname.endsWith("/deliveries")) return Response.json({ deliveries: [SENT] });
    if (!pathname.startsWith("/webhooks/")) return Response.json({}, { status: 404 });
    const body = method === "PUT" ? ((await request.json()) as WebhookBody) : null;
    asked.push({ method, path: pathname, body });
    if (pathname.endsWith("/test")) return Response.json(tested);
    const id = pathname.split("/")[2] ?? "";
    const known = webhooks.find((webhook) => webhook.id === id);
    webhooks = webhooks.filter((webhook) => webhook.id !== id);
    if (body === null) return new Response(null, { status: 204 });
    const stored = { ...(known ?? ROOM), id, name: body.name, url: body.url, enabled: body.enabled ?? true };
    webhooks = [...webhooks, stored];
    return Response.json({ ...stored, secret: known === undefined ? "whsec_new" : null });
  });
  return asked;
}

const open = () => renderPage(fakeGateway(), {}, "/ui/notifications");

describe("what is typed", () => {
  it("becomes a request", () => {
    expect(
      bodyOf({ ...draftOf(null), name: " A ", url: " https://a/b ", warnings: false }, true, "Ada"),
    ).toEqual({
      name: "A",
      url: "https://a/b",
      enabled: true,
      severities: ["critical"],
      robots: { all: true },
      by: "Ada",
    });
    expect(errorsOf(draftOf(ROOM))).toEqual({});
    expect(switched(ROOM, false, null)).toMatchObject({
      enabled: false,
      url: ROOM.url,
      robots: { all: true },
    });
  });

  it("is checked", () => {
    const draft = draftOf(ROOM);
    expect(errorsOf({ ...draft, name: " ", all: false })).toEqual({
      name: "Type a name.",
      robots: "Choose a robot or a group.",
    });
    for (const url of ["", "hooks.example.com", "ftp://a/b"])
      expect(errorsOf({ ...draft, url }).url).toMatch(/begins with https/);
    expect(errorsOf({ ...draft, url: "https://ada:secret@a/b" }).url).toBe(
      "Leave out user name and password.",
    );
  });
});

describe("the words", () => {
  it("say what came of a delivery", () => {
    expect(outcomeWords(SENT)).toBe("204");
    expect(outcomeWords({ ...SENT, attempts: 3 })).toBe("204, attempt 3");
    const failed: Delivery = { ...SENT, state: "failed", attempts: 8, error: "the answer was 503" };
    expect(outcomeWords(failed)).toBe("The answer was 503, attempt 8");
    const pending: Delivery = { ...failed, state: "pending", next_at: "2026-11-23T10:00:05Z" };
    expect(outcomeWords(pending)).toMatch(/^The answer was 503, attempt 8\. Next at .*\d\d:\d\d:\d\d$/);
    expect(outcomeWords({ ...pending, attempts: 0, error: null })).toBe("");
    expect(testWords({ ...failed, error: "no answer within 10 s" })).toBe("no answer within 10 s");
  });
});

describe("the page", () => {
  it("adds a webhook and shows its secret once", async () => {
    const asked = answering([]);
    const { user } = open();
    await screen.findByText(/A webhook tells another system/);
    await user.click(screen.getByRole("button", { name: "New webhook" }));
    const dialog = await screen.findByRole("dialog", { name: "New webhook" });
    await user.click(within(dialog).getByRole("button", { name: "Save" }));
    expect(within(dialog).getByText("Type a name.")).toBeDefined();
    await user.type(within(dialog).getByRole("textbox", { name: "Name" }), "Büro");
    await user.type(within(dialog).getByRole("textbox", { name: "Address" }), "https://a/b");
    await user.click(within(dialog).getByRole("button", { name: "Save" }));
    expect(await screen.findByText("whsec_new")).toBeDefined();
    expect(asked).toMatchObject([
      { method: "PUT", path: "/webhooks/buro", body: { name: "Büro", enabled: true } },
    ]);
    await screen.findByText("Büro");
  });

  it("tests, switches off and removes one", async () => {
    const asked = answering([{ ...ROOM, last_delivery: SENT }], {
      ...SENT,
      type: "test",
      state: "failed",
      error: "no connection",
    });
    const { user } = open();
    await user.click(await screen.findByRole("button", { name: "Test Control room" }));
    expect(await screen.findByText("no connection")).toBeDefined();
    await user.click(screen.getByText(/Last delivered/));
    expect(await screen.findByText("Low battery, /robot1")).toBeDefined();
    await user.click(screen.getByRole("switch", { name: "Control room is on" }));
    await waitFor(() =>
      expect(screen.getByRole<HTMLInputElement>("switch", { name: "Control room is on" }).checked).toBe(
        false,
      ),
    );
    await user.click(screen.getByRole("button", { name: "Remove Control room" }));
    const dialog = await screen.findByRole("dialog", { name: "Remove Control room?" });
    await user.click(within(dialog).getByRole("button", { name: "Remove" }));
    await screen.findByText(/A webhook tells another system/);
    expect(asked.map(({ method }) => method)).toEqual(["POST", "PUT", "DELETE"]);
  });
});
