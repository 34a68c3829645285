import { act, screen, waitFor, within } from "@testing-library/react";
import { Link } from "react-router";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { App } from "../../src/layout/App";
// Loaded on demand by the page: on a busy machine its first import takes longer than a test waits.
import "../../src/pages/robot/LabelForm";
import { alert, goal, latched, robot } from "../events";
import { fakeGateway, renderPage, renderWithin, robotServices } from "../page";

beforeEach(() => localStorage.clear());

const named = robot("/robot1", { display_name: "Left forklift", groups: ["Hall 1"] });
const plain = robot("/robot2");
const PAGE = "/ui/robot?robot=/robot1";

const LABEL = "http://gateway:8000/label?robot=%2Frobot1";
const label = { robot: "/robot1", display_name: "Left forklift", groups: ["Hall 1"], etag: '"1"' };

/** A gateway that answers a change of the label with this; it has had the one before. */
function answers(body: unknown, status = 200, present = label) {
  const fetched = vi.fn(async ({ url, method }: Request) => {
    if (url.endsWith("/automation/rules")) return Response.json({ rules: [] });
    return method === "GET" && url === LABEL ? Response.json(present) : Response.json(body, { status });
  });
  vi.stubGlobal("fetch", fetched);
  return fetched;
}

/** The labels that were sent, and for which version. The page asks for other things, too. */
async function labelsPut(fetched: ReturnType<typeof answers>): Promise<[unknown, string | null][]> {
  const sent = fetched.mock.calls.map(([request]) => request).filter(({ method }) => method === "PUT");
  for (const { url } of sent) expect(url).toBe(LABEL);
  return Promise.all(sent.map(async (each) => [await each.json(), each.headers.get("If-Match")]));
}

const button = (name: string) => screen.getByRole("button", { name });

async function openDialog({ user }: ReturnType<typeof renderPage>) {
  await user.click(button("Name and groups of Left forklift"));
  return within(
    await screen.findByRole(
      "dialog",
      { name: "Name and groups of Left forklift (/robot1)" },
      { timeout: 5000 },
    ),
  );
}

describe("the dialog of a robot's name and groups", () => {
  it("closes where another robot is shown", async () => {
    answers({});
    const { fleet } = robotServices(fakeGateway(), { robots: [named, plain] });
    const page = (
      <>
        <App />
        <Link to="/ui/robot?robot=/robot2">elsewhere</Link>
      </>
    );
    renderWithin(fleet, page, PAGE);
    act(() => button("Name and groups of Left forklift").click());
    await screen.findByLabelText("Name");
    act(() => screen.getByText("elsewhere").click());
    await waitFor(() =>
      expect(screen.getByRole("heading", { level: 1, hidden: true }).textContent).toBe("/robot2"),
    );
    expect(screen.queryByRole("dialog")).toBeNull();
  });

  it("begins with those that it has, and sends both", async () => {
    const fetched = answers({
      robot: "/robot1",
      display_name: "Right forklift",
      groups: ["Hall 1", "spare"],
    });
    const page = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    const dialog = await openDialog(page);
    const name = await dialog.findByLabelText("Name");
    expect(name).toHaveProperty("value", "Left forklift");
    await page.user.clear(name);
    await page.user.type(name, " Right forklift ");
    await page.user.type(dialog.getByRole("combobox", { name: "Groups" }), "spare{Enter}");
    await page.user.click(dialog.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(await labelsPut(fetched)).toEqual([
      [{ display_name: "Right forklift", groups: ["Hall 1", "spare"] }, '"1"'],
    ]);
  });

  it("removes a name that is emptied", async () => {
    const fetched = answers({ robot: "/robot1", display_name: null, groups: ["Hall 1"] });
    const page = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    const dialog = await openDialog(page);
    await page.user.clear(await dialog.findByLabelText("Name"));
    await page.user.keyboard("{Enter}");
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(await labelsPut(fetched)).toEqual([[{ display_name: null, groups: ["Hall 1"] }, '"1"']]);
  });

  it("stays open with what the gateway refuses", async () => {
    answers({ code: "display_name_taken", title: "Conflict", detail: "it is that of /robot2" }, 409);
    const page = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    const dialog = await openDialog(page);
    await page.user.click(await dialog.findByRole("button", { name: "Save" }));
    expect(await dialog.findByText(/the name is taken/)).toBeDefined();
    expect(dialog.getByText(/choose a different one/)).toBeDefined();
  });
});

describe("a name that someone else has changed meanwhile", () => {
  const theirs = { ...label, display_name: "Spare", groups: [], etag: '"2"' };

  it("is not lost: both can be seen, and one is chosen", async () => {
    const fetched = answers({ code: "changed_meanwhile", title: "Changed", detail: "it was changed" }, 412);
    const page = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    const dialog = await openDialog(page);
    await page.user.type(await dialog.findByLabelText("Name"), " 2");
    answers({ code: "changed_meanwhile", title: "Changed", detail: "it was changed" }, 412, theirs);
    await page.user.click(dialog.getByRole("button", { name: "Save" }));
    expect(await dialog.findByText(/Someone else has changed it meanwhile/)).toBeDefined();
    expect(dialog.getByLabelText("Name")).toHaveProperty("value", "Left forklift 2");
    expect(fetched.mock.calls.every(([{ method }]) => method === "GET")).toBe(true);
    await page.user.click(dialog.getByRole("button", { name: "Show the new version" }));
    await waitFor(() => expect(dialog.getByLabelText("Name")).toHaveProperty("value", "Spare"));
    const again = answers({ ...theirs, display_name: "Mine" }, 200, theirs);
    await page.user.type(dialog.getByLabelText("Name"), " 3");
    await page.user.click(dialog.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(await labelsPut(again)).toEqual([[{ display_name: "Spare 3", groups: [] }, '"2"']]);
  });
});

describe("the display name", () => {
  it("heads the robot's page beside its namespace, and is on its Stop and in the question before it moves", async () => {
    const { user } = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    expect(screen.getByRole("heading", { level: 1 }).textContent).toBe("Left forklift");
    expect(screen.getByText("/robot1")).toBeDefined();
    expect(button("Stop Left forklift").title).toMatch("every goal of Left forklift (/robot1) is canceled");
    await user.click(button("Dock"));
    expect(await screen.findByRole("dialog", { name: "Dock Left forklift (/robot1)?" })).toBeDefined();
  });

  it("is on the banner of a stop and in the question before its release", async () => {
    const stop = { ...latched("Ada"), robots: ["/robot1"] };
    const { user } = renderPage(fakeGateway(), { robots: [{ ...named, stop }, plain] });
    const banner = within(screen.getByTestId("stop-banner"));
    const words = banner.getByText(/^Left forklift stopped by Ada/);
    expect(words.title).toBe("Left forklift (/robot1)");
    await user.click(banner.getByRole("button", { name: "Release …" }));
    const dialog = within(await screen.findByRole("dialog", { name: "Release the stop?" }));
    expect(dialog.getByText("Left forklift (/robot1)")).toBeDefined();
  });

  it("is in the notice of a stop", async () => {
    const { user } = renderPage(fakeGateway(), { robots: [named, plain] }, PAGE);
    await user.click(button("Stop Left forklift"));
    expect(await screen.findByText("Stopped Left forklift (/robot1)")).toBeDefined();
  });

  it("is in alerts, and to choose by in lists of goals", async () => {
    answers({ goals: [], next_cursor: null, tags: [] });
    const label = "Left forklift (/robot1)";
    const robots = [named, plain];
    renderPage(fakeGateway(), { robots, alerts: [alert("low")] });
    expect(button(`Acknowledge: Low battery: ${label}`)).toBeDefined();
    document.body.replaceChildren();
    renderPage(fakeGateway(), { robots }, "/ui/goals");
    const select = await screen.findByRole("combobox", { name: "Robot" }, { timeout: 5000 });
    const options = within(select).getAllByRole("option");
    expect(options.map(({ textContent }) => textContent)).toEqual(["All robots", "/robot2", label]);
  });

  it("is in the title of a goal, above the action", async () => {
    const listed = goal("g1", { action_name: "/robot1/dock", status: "succeeded" });
    answers({ goals: [{ ...listed, origin: "gateway" }], next_cursor: null, tags: [] });
    renderPage(fakeGateway(), { robots: [named, plain] }, "/ui/goals");
    const cell = await screen.findByRole("cell", { name: /\/robot1\/dock$/ }, { timeout: 5000 });
    expect(cell.textContent).toBe("Dock, Left forklift/robot1/dock");
  });
});

describe("groups in the overview", () => {
  const rows = () => screen.getAllByTestId(/^robot \//).map(({ dataset }) => dataset.testid);

  it("are neither a filter nor a column where there are none", async () => {
    renderPage(fakeGateway(), { robots: [plain, robot("/robot3")] });
    await screen.findAllByTestId(/^robot \//);
    expect(screen.queryByRole("combobox", { name: "Group" })).toBeNull();
    expect(screen.queryByRole("columnheader", { name: "Groups" })).toBeNull();
  });

  it("narrow the list, in its address, until all are shown again", async () => {
    const spare = robot("/robot3", { groups: ["spare"] });
    const { store, user } = renderPage(fakeGateway(), { robots: [named, plain, spare] });
    expect(await screen.findByRole("columnheader", { name: "Groups" })).toBeDefined();
    await user.selectOptions(screen.getByRole("combobox", { name: "Group" }), "spare");
    expect(rows()).toEqual(["robot /robot3"]);
    const time = new Date().toISOString();
    act(() => store.onEvent({ type: "robots", time, robots: [{ ...spare, groups: [] }], gone: [] }));
    await user.click(await screen.findByRole("button", { name: "Show all 3" }));
    expect(rows()).toHaveLength(3);
  });
});
