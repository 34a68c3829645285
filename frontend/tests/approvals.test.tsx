import type { Approval } from "@dock-gateway/client";
import { act, screen, waitFor, within } from "@testing-library/react";
import { afterEach, describe, expect, it, vi } from "vitest";
import { at, robot } from "./events";
import { fakeGateway, renderPage } from "./page";

afterEach(() => vi.unstubAllGlobals());

const approval: Approval = {
  id: "a1",
  agent: "shift planner",
  client: "planner 1.0",
  robot: "/robot1",
  action_name: "/robot1/dock",
  verb: "dock",
  goal: {},
  requested_at: at(0),
  expires_at: at(60),
};
const robots = [robot("/robot1", { display_name: "Left forklift" })];

const problem = (code: string, detail: string) =>
  Response.json({ code, title: "Not found", detail }, { status: 404 });

/** A gateway that answers only what is sent to `/approvals`. */
function answers(answer: () => Response) {
  const fetched = vi.fn<(request: Request) => Promise<Response>>(async ({ method }) =>
    method === "PUT" ? answer() : problem("not_found", "there is nothing"),
  );
  vi.stubGlobal("fetch", fetched);
  return fetched;
}

describe("the goal of an agent that waits for somebody", () => {
  it.each([
    ["Allow", true],
    ["Refuse", false],
  ])("is answered by %s", async (button, allow) => {
    const fetched = answers(() => Response.json(approval));
    const { user } = renderPage(fakeGateway(), { robots, approvals: [approval] });
    const question = within(
      await screen.findByRole("region", { name: "shift planner wants to dock Left forklift (/robot1)" }),
    );
    expect(question.getByText(/An agent, planner 1.0, asks/)).toBeDefined();
    await user.click(question.getByRole("button", { name: `${button}: dock Left forklift (/robot1)` }));
    await waitFor(() => expect(screen.queryByTestId("approval")).toBeNull());
    const sent = fetched.mock.calls.map(([request]) => request).find(({ method }) => method === "PUT");
    expect(sent?.url).toBe("http://gateway:8000/approvals/a1/decision");
    expect(await sent?.json()).toEqual({ allow });
  });

  it("says what did not work, and goes when it no longer waits", async () => {
    answers(() => problem("approval_not_found", "it has expired"));
    const other: Approval = { ...approval, verb: null, action_name: "/arm/move", goal: { order: 3 } };
    const { store, user } = renderPage(fakeGateway(), { robots, approvals: [other] });
    expect(await screen.findByText('{"order":3}')).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Allow: send a goal to /arm/move" }));
    expect(await screen.findByText("It has expired")).toBeDefined();
    act(() => store.onEvent({ type: "approvals", time: at(1), approvals: [] }));
    await waitFor(() => expect(screen.queryByTestId("approval")).toBeNull());
  });
});
