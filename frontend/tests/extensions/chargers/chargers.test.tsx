import { screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import type { SharedDock } from "../../../src/extensions/chargers/requests";
import { canBeCleared, holderWords, nameError } from "../../../src/extensions/chargers/words";
// Loaded on demand by the page: on a busy machine its first import takes longer than a test waits.
import "../../../src/extensions/chargers/DocksPage";
import type { Naming } from "../../../src/fleet/names";
import { at, emptyScene, robot } from "../../events";
import { fakeGateway, renderPage } from "../../page";
import { streams, tell } from "../../streams";

const LAB: SharedDock = {
  dock_id: "lab",
  etag: '"1"',
  robots: { all: true, names: [], groups: [] },
  pose: null,
  type: null,
  waiting_places: [],
  changed_by: "Ada",
  changed_at: "2026-11-30T09:00:00Z",
  state: "occupied",
  detail: "/robot1 stands on the dock.",
  robot: "/robot1",
  since_at: "2026-11-30T10:00:00Z",
  goal_ids: [],
  out_of_order_at: null,
  note: null,
  failures: 0,
  waiting: [{ robot: "/robot2", since_at: "2026-11-30T10:05:00Z", battery: 0.2, wait_at: null }],
};
const NAMING = { nameOf: (robot: string) => robot } as Naming;

/** A gateway with these docks; it remembers what it is asked. */
function answering(docks: SharedDock[]) {
  const asked: { method: string; path: string; body: unknown }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const { pathname } = new URL(request.url);
    if (pathname === "/shared-docks") return Response.json({ shared_docks: docks });
    if (!pathname.startsWith("/shared-docks/")) return Response.json({}, { status: 404 });
    const { method } = request;
    asked.push({ method, path: pathname, body: method === "DELETE" ? null : await request.json() });
    if (method === "DELETE") docks = [];
    return method === "DELETE" ? new Response(null, { status: 204 }) : Response.json(LAB);
  });
  return asked;
}

const open = () => renderPage(fakeGateway(), { robots: [robot("/robot1")] }, "/ui/docks");

describe("the words", () => {
  it("say who has a dock, and what to do", () => {
    expect(holderWords(LAB, NAMING)).toBe("/robot1 stands here.");
    expect(holderWords({ ...LAB, state: "reserved", robot: null }, NAMING)).toBe(
      "Another robot is on its way.",
    );
    const broken: SharedDock = { ...LAB, state: "out_of_order", note: "The cable is loose" };
    expect(holderWords(broken, NAMING)).toBe("No robot is sent here: The cable is loose. /robot1 has it.");
    expect(canBeCleared(LAB)).toBe(true);
    expect(canBeCleared({ ...LAB, state: "reserved" })).toBe(false);
    expect(canBeCleared({ ...LAB, state: "free", since_at: null })).toBe(false);
  });

  it("say what is no name of a dock", () => {
    expect(nameError(" lab_1.b ", ["lab"])).toBeUndefined();
    expect(nameError("lab", ["lab"])).toBe("This dock is shared already.");
    for (const name of ["", "-a", "a b"]) expect(nameError(name, [])).toMatch(/dock_id/);
  });
});

describe("the page", () => {
  it("teaches what a shared dock is, and shares one", async () => {
    const asked = answering([]);
    const { user } = open();
    expect(await screen.findByText(/at most one robot drives there/)).toBeDefined();
    await user.click(await screen.findByRole("button", { name: "Share a dock" }));
    await user.click(await screen.findByRole("button", { name: "Save" }));
    expect(await screen.findByText(/Type the dock_id/)).toBeDefined();
    await user.type(screen.getByLabelText("Name"), "lab");
    await user.click(screen.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    expect(asked[0]).toMatchObject({
      method: "PUT",
      path: "/shared-docks/lab",
      body: { robots: { all: true } },
    });
  });

  it("learns where it is and where robots wait for it", async () => {
    const asked = answering([{ ...LAB, pose: { frame: "map", x: 1, y: 2.5, theta: 0 } }]);
    const { user } = open();
    expect(await screen.findByText("At x 1 m, y 2.5 m")).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Edit lab" }));
    const where = within(await screen.findByRole("group", { name: "Where it is" }));
    await user.click(where.getByRole("button", { name: "Forget it" }));
    await user.click(where.getByRole("button", { name: /Use where/ }));
    await waitFor(() => expect(streams.some(({ url }) => url.includes("scene"))).toBe(true));
    tell({
      type: "scene",
      robot: "/robot1",
      time: at(0),
      scene: { ...emptyScene, robot: { x: 4, y: 1.5, theta: Math.PI / 2 } },
    });
    await waitFor(() => expect(where.getByLabelText("X")).toHaveProperty("value", "4 m"));
    const waiting = within(screen.getByRole("group", { name: "Where robots wait for it" }));
    await user.click(waiting.getByRole("button", { name: "Type a place" }));
    await user.click(waiting.getByRole("button", { name: "Add it" }));
    expect(await waiting.findAllByText("A number of metres")).toHaveLength(2);
    await user.type(waiting.getByLabelText("X"), "6");
    await user.type(waiting.getByLabelText("Y"), "-1");
    await user.click(waiting.getByRole("button", { name: "Add it" }));
    expect(waiting.getByText("x 6 m, y -1 m")).toBeDefined();
    await user.type(screen.getByLabelText("Type"), "wall_dock");
    await user.click(screen.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    expect(asked[0]?.body).toMatchObject({
      pose: { frame: "map", x: 4, y: 1.5 },
      type: "wall_dock",
      waiting_places: [{ frame: "map", x: 6, y: -1, theta: 0 }],
    });
  });

  it("shows who stands there and who waits, and takes what a person says", async () => {
    const asked = answering([LAB]);
    const { user } = open();
    expect(await screen.findByText(/\/robot1 stands here/)).toBeDefined();
    expect(screen.getByText(/in this order: \/robot2/)).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Nobody stands at lab" }));
    await user.click(screen.getByRole("switch", { name: "Out of order" }));
    await waitFor(() => expect(asked).toHaveLength(2));
    expect(asked.map(({ body }) => body)).toMatchObject([{ occupied_by: "nobody" }, { out_of_order: true }]);
    await user.click(screen.getByRole("button", { name: "Remove lab" }));
    await user.click(await screen.findByRole("button", { name: "Remove" }));
    expect(await screen.findByText("No shared docks")).toBeDefined();
  });
});
