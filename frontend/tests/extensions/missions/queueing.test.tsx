import { screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/missions/EditMissionPage";
import "../../../src/extensions/missions/MissionPage";
import "../../../src/extensions/missions/MissionsPage";
import "../../../src/extensions/missions/NewMissionPage";
import type { Mission } from "../../../src/extensions/missions/requests";
import { robot } from "../../events";
import { fakeGateway, isDisabled, renderPage } from "../../page";
import { tell } from "../../streams";
import { ANY, CHARGE, DOCK, NIGHT, QUEUED } from "./examples";

const SECOND: Mission = { ...QUEUED, mission_id: "s", name: "Second", order: 2, steps: [DOCK, CHARGE] };
const FIRST: Mission = { ...QUEUED, mission_id: "f", name: "First", order: 1 };

let missions: Mission[] = [];
let asked: { method: string; path: string; body: string; match: string | null }[] = [];

function changeTo(id: string, change: Partial<Mission>): Mission {
  missions = missions.map((each) => (each.mission_id === id ? { ...each, ...change } : each));
  return missions.find(({ mission_id }) => mission_id === id) ?? QUEUED;
}

const tellOf = (mission: Mission) => tell({ type: "mission", time: NIGHT.created_at, mission });

/** What a gateway does with these missions. */
async function answer(request: Request): Promise<Response> {
  const { pathname, searchParams, search } = new URL(request.url);
  const id = pathname.split("/")[2] ?? "";
  const found = missions.find(({ mission_id }) => mission_id === id);
  if (request.method === "GET") {
    if (pathname === "/missions") {
      const wanted = searchParams.getAll("status");
      return Response.json({
        missions: missions.filter(({ status }) => wanted.includes(status)),
        next_cursor: null,
      });
    }
    return found === undefined ? Response.json({}, { status: 404 }) : Response.json(found);
  }
  const match = request.headers.get("If-Match");
  asked.push({ method: request.method, path: pathname + search, body: await request.text(), match });
  if (request.method === "PUT" && found?.etag !== match) {
    const problem = {
      status: 412,
      code: "changed_meanwhile",
      title: "Changed",
      detail: "someone was faster",
    };
    return Response.json(problem, { status: 412 });
  }
  return Response.json(pathname.endsWith("/move") ? changeTo(id, { order: 0 }) : (found ?? QUEUED));
}

beforeEach(() => {
  asked = [];
  vi.stubGlobal("fetch", answer);
});

const ROBOTS = {
  robots: [robot("/robot1", { groups: ["pickers"] }), robot("/robot2", { groups: ["pickers"] })],
};
const open = (path = "/ui/missions") => renderPage(fakeGateway(), ROBOTS, path);

describe("a mission for a group", () => {
  it("is sent without a robot", async () => {
    missions = [];
    const { user } = open("/ui/missions/new");
    await user.selectOptions(await screen.findByLabelText("For"), "Any of pickers");
    expect(screen.getByText(/One of \/robot1, \/robot2 begins as soon as it is free/)).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Add step: Dock" }));
    await user.click(screen.getByRole("button", { name: "Start mission" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    expect(asked[0]?.path).toBe("/missions");
    expect(JSON.parse(asked[0]?.body ?? "").group).toBe("pickers");
  });

  it("may be given to a robot again", async () => {
    missions = [];
    const { user } = open("/ui/missions/new");
    const taker = await screen.findByLabelText("For");
    await user.selectOptions(taker, "Any of pickers");
    await user.selectOptions(taker, "/robot2");
    await user.click(screen.getByRole("button", { name: "Add step: Dock" }));
    await user.click(screen.getByRole("button", { name: "Start mission" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    expect(asked[0]?.path).toBe("/missions?robot=%2Frobot2");
    expect(JSON.parse(asked[0]?.body ?? "")).not.toHaveProperty("group");
  });
});

describe("a queued mission", () => {
  it("is changed by the form, from the version that was read", async () => {
    missions = [FIRST, SECOND];
    const { user } = open();
    await user.click(await screen.findByRole("link", { name: "Edit: Second" }));
    const name = await screen.findByRole("textbox", { name: "Name" });
    expect(screen.queryByLabelText("For")).toBeNull();
    await user.clear(name);
    await user.type(name, "Later");
    await user.click(screen.getByRole("button", { name: "Remove step 2" }));
    await user.click(screen.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    const [{ method, path, match, body } = { body: "" }] = asked;
    expect([method, path, match]).toEqual(["PUT", "/missions/s", '"0"']);
    expect(JSON.parse(body)).toMatchObject({ name: "Later", steps: [{ dock: {} }] });
    await screen.findByRole("heading", { name: "Missions" });
  });

  it("says when somebody was faster, and shows or replaces what they did", async () => {
    missions = [SECOND];
    const { user } = open("/ui/missions/s/edit");
    const name = await screen.findByRole("textbox", { name: "Name" });
    await user.type(name, " one");
    tellOf(changeTo("s", { name: "Theirs", etag: '"1"' }));
    await user.click(screen.getByRole("button", { name: "Save" }));
    const alert = await screen.findByRole("alert");
    expect(within(alert).getByText("Someone else has changed it meanwhile")).toBeDefined();
    await user.click(within(alert).getByRole("button", { name: "Show the new version" }));
    expect(screen.getByRole("textbox", { name: "Name" })).toHaveProperty("value", "Theirs");
    expect(screen.queryByRole("alert")).toBeNull();
    changeTo("s", { etag: '"2"' });
    await user.click(screen.getByRole("button", { name: "Save" }));
    await screen.findByRole("button", { name: "Replace it with mine" });
    tellOf(changeTo("s", { name: "Theirs again" }));
    await user.click(screen.getByRole("button", { name: "Replace it with mine" }));
    await waitFor(() => expect(asked.map(({ match }) => match)).toEqual(['"0"', '"1"', '"2"']));
    expect(JSON.parse(asked[2]?.body ?? "").name).toBe("Theirs");
  });

  it("is not changed once it has begun", async () => {
    missions = [SECOND];
    open("/ui/missions/s/edit");
    await screen.findByRole("textbox", { name: "Name" });
    tellOf(changeTo("s", { status: "running", started_at: NIGHT.started_at }));
    await screen.findByText("It has begun meanwhile");
    expect(isDisabled("Save")).toBe(true);
  });

  it("is as an event says that comes while it is being read", async () => {
    missions = [SECOND];
    let answerNow = () => {};
    const wait = new Promise<void>((resolve) => {
      answerNow = resolve;
    });
    const slow = vi.fn(async (request: Request) => {
      const before = await answer(request);
      await wait;
      return before;
    });
    vi.stubGlobal("fetch", slow);
    open("/ui/missions/s/edit");
    await waitFor(() => expect(slow.mock.calls.some(([{ url }]) => url.endsWith("/missions/s"))).toBe(true));
    tellOf(changeTo("s", { status: "running", started_at: NIGHT.started_at }));
    answerNow();
    await screen.findByText("It has begun meanwhile");
  });

  it("is moved with buttons, which keep the focus and say where it is", async () => {
    missions = [FIRST, SECOND];
    const { user } = open();
    const up = await screen.findByRole("button", { name: "Move Second up" });
    expect(screen.getByRole("button", { name: "Move First up" })).toHaveProperty("disabled", true);
    await user.click(up);
    await screen.findByText("Second is now number 1 of 2");
    expect(asked).toMatchObject([{ path: "/missions/s/move", body: JSON.stringify({ before: "f" }) }]);
    const rows = within(screen.getByRole("list", { name: "Next for /robot1" })).getAllByRole("listitem");
    expect(rows.map((row) => row.dataset.mission)).toEqual(["s", "f"]);
    // It is the first one now, which cannot go further up.
    await waitFor(() => expect(document.activeElement).toBe(rows[0]));
    await user.click(screen.getByRole("button", { name: "Move Second down" }));
    await waitFor(() => expect(asked).toHaveLength(2));
    expect(asked[1]?.body).toBe(JSON.stringify({ after: "f" }));
  });

  it("alone in its queue has no buttons to move it, and one that has begun none to edit it", async () => {
    missions = [NIGHT, SECOND, ANY];
    open();
    await screen.findByRole("link", { name: "Edit: Second" });
    expect(screen.queryByRole("button", { name: /^Move / })).toBeNull();
    expect(screen.queryByRole("link", { name: "Edit: Night" })).toBeNull();
  });
});
