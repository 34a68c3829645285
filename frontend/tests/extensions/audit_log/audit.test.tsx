import { screen, waitFor } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { ANYBODY, session } from "../../../src/api/session";
import { type AuditRecord, auditExportUrl } from "../../../src/extensions/audit_log/requests";
import "../../../src/extensions/audit_log/AuditPage";
import { auditFilter, toQuery, whatWords } from "../../../src/extensions/audit_log/filter";
import { fakeGateway, renderPage } from "../../page";

const GOAL = "7d9c1c9e-0000-4000-8000-00000000000a";
const RECORD: AuditRecord = {
  sequence: 7,
  id: "a".repeat(32),
  acted_at: "2026-11-23T09:00:00Z",
  principal: "Ada",
  role: "supervisor",
  token_id: "0123456789abcdef",
  client: "192.0.2.1",
  request_id: null,
  what: "dock",
  robot: "/robot1",
  action_name: "/robot1/connect_to_charging_dock",
  goal_id: GOAL,
  subject: null,
  status: 202,
  code: null,
  outcome: "done",
  digest: "f".repeat(64),
};

/** A gateway with these records, a page each; it remembers what it is asked. */
function answering(...pages: AuditRecord[][]) {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request | string) => {
    if (typeof request === "string") return Response.json(session.state);
    const { pathname, search, searchParams } = new URL(request.url);
    if (pathname !== "/audit") return Response.json({}, { status: 404 });
    asked.push(search);
    const page = Number(searchParams.get("cursor") ?? 0);
    const next_cursor = page + 1 < pages.length ? page + 1 : null;
    return Response.json({ records: pages[page] ?? [], next_cursor });
  });
  return asked;
}

beforeEach(() => session.set(ANYBODY));

describe("the filter", () => {
  it("lives in the address", () => {
    const filter = {
      ...auditFilter.initial,
      principal: "Ada & Bob",
      outcome: "refused" as const,
      goalId: GOAL,
    };
    expect(auditFilter.read(auditFilter.write(filter))).toEqual(filter);
    expect(auditFilter.read(new URLSearchParams("outcome=x&goal_id=y"))).toEqual(auditFilter.initial);
    expect(auditFilter.write(auditFilter.initial).size).toBe(0);
    expect(toQuery(filter, 0)).toEqual({ principal: "Ada & Bob", outcome: "refused", goal_id: GOAL });
    expect(auditExportUrl({ what: "stop" }, "csv")).toBe("/audit/export?format=csv&what=stop");
  });

  it("has words for what it does not know", () => {
    expect(whatWords("release_stop")).toBe("Release the stop");
    expect(whatWords("paint_robot")).toBe("Paint robot");
  });
});

describe("the page", () => {
  it("lists who did what, and loads older records", async () => {
    const refused = {
      ...RECORD,
      sequence: 6,
      outcome: "refused" as const,
      code: "dock_busy",
      principal: null,
    };
    answering([RECORD], [{ ...refused, role: null, subject: "a subject" }]);
    const { user } = renderPage(fakeGateway(), {}, "/ui/audit");
    expect((await screen.findByRole("row", { name: /Ada/ })).textContent).toContain("/robot1");
    expect(screen.getAllByRole("link", { name: "Goal 7d9c1c9e" })[0]?.getAttribute("href")).toBe(
      `/ui/goals/${GOAL}`,
    );
    await user.click(screen.getByRole("button", { name: "Load older records" }));
    const row = await screen.findByRole("row", { name: /Refused/ });
    expect(row.textContent).toContain("Unknown");
    expect(row.textContent).toContain("a subject");
    expect(screen.queryByRole("button", { name: "Load older records" })).toBeNull();
  });

  it("asks for what it is narrowed to, when Enter is pressed", async () => {
    const asked = answering([]);
    const { user } = renderPage(fakeGateway(), {}, "/ui/audit?what=dock");
    await screen.findByText("No record fits");
    await user.type(screen.getByLabelText("Who"), "Ada");
    expect(asked).toEqual(["?what=dock&limit=50"]);
    await user.keyboard("{Enter}");
    await waitFor(() => expect(asked.at(-1)).toBe("?principal=Ada&what=dock&limit=50"));
    await user.type(screen.getByLabelText("Goal id"), "no id{Enter}");
    expect(screen.getByText("The whole id of a goal")).toBeTruthy();
    expect(asked).toHaveLength(2);
  });

  it("is for admins", async () => {
    const asked = answering([RECORD]);
    session.set({
      required: true,
      open_to: null,
      principal: { name: "Ada", kind: "token", role: "viewer", robots: [], actions: [], topics: [] },
      provider: null,
      share: [],
    });
    renderPage(fakeGateway(), {}, "/ui/audit");
    expect(await screen.findByText("Needs the role admin; you are viewer.")).toBeTruthy();
    expect(asked).toEqual([]);
  });
});
