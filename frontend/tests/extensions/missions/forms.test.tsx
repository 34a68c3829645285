import { screen, waitFor } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/missions/schedules/SchedulesPage";
import "../../../src/extensions/missions/templates/TemplatesPage";
import { robot } from "../../events";
import { fakeGateway, isDisabled, renderPage } from "../../page";

/** A gateway without templates and schedules, which refuses one field of what is stored. */
function refusing(path: string) {
  vi.stubGlobal("fetch", async (request: Request) => {
    if (request.method === "GET") return Response.json({ templates: [], schedules: [] });
    const fields = [{ path, expected: "a dock that is there", detail: "got lab" }];
    const problem = {
      status: 422,
      code: "invalid_field",
      title: "Invalid field",
      detail: path,
      errors: fields,
    };
    return Response.json(problem, { status: 422 });
  });
}

describe.each([
  { what: "template", path: "templates", at: "steps.0.dock.dock_id", number: /^1Dock/ },
  { what: "schedule", path: "schedules", at: "mission.steps.1.dock.dock_id", number: /^2Dock/ },
])("a $what that the gateway refuses", ({ what, path, at, number }) => {
  it("has the reason at its step", async () => {
    refusing(at);
    const { user } = renderPage(fakeGateway(), { robots: [robot("/robot1")] }, `/ui/missions/${path}`);
    await screen.findByText(`No ${what}s`);
    await waitFor(() => expect(isDisabled(`New ${what}`)).toBe(false));
    await user.click(screen.getByRole("button", { name: `New ${what}` }));
    await user.type(await screen.findByRole("textbox", { name: "Name" }), "Night");
    await user.click(screen.getByRole("button", { name: "Save" }));
    const step = (await screen.findByText(/expected a dock that is there, got lab/)).closest(
      "li, [role=group]",
    );
    expect(step?.textContent).toMatch(number);
  });
});
