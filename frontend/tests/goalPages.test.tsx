import type { LiveGoal } from "@dock-gateway/client";
import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import { battery, feedback, goal, latched, result, START, snapshot, status } from "./events";
import { fakeGateway, renderPage } from "./page";
import { streams, tell } from "./streams";

type Answer = (request: Request, path: string) => unknown;

/** A gateway that answers over HTTP with what a test gives for the beginning of a path; else 404. */
function answering(more: Record<string, Answer>) {
  const answers: Record<string, Answer> = {
    "GET /goals/tags": () => ({ tags: [] }),
    ...more,
  };
  const fetch = vi.fn(async (request: Request) => {
    const path = request.url.replace("http://gateway:8000", "");
    const found = Object.keys(answers).find((start) => `${request.method} ${path}`.startsWith(start));
    if (found !== undefined) {
      const answer = answers[found]?.(request, path) ?? null;
      return answer instanceof Response ? answer : Response.json(answer);
    }
    return Response.json(
      { title: "t", status: 404, code: "goal_not_found", detail: `no ${path}` },
      { status: 404 },
    );
  });
  vi.stubGlobal("fetch", fetch);
  const asked = () => fetch.mock.calls.map(([request]) => `${request.method} ${request.url.slice(19)}`);
  return { fetch, asked };
}

const at = (seconds: number) => new Date(Date.now() + seconds * 1000).toISOString();
const button = (name: string | RegExp) => screen.getByRole<HTMLButtonElement>("button", { name });
const rows = () => within(screen.getByRole("table")).getAllByRole("row").slice(1);
const ended = (id: string, seconds: number, change: Partial<LiveGoal> = {}) =>
  goal(id, {
    status: "succeeded",
    created_at: at(seconds),
    updated_at: at(seconds + 3),
    finished_at: at(seconds + 3),
    ...(change as object),
  });

describe("the list of goals", () => {
  const actions = () => ({ actions: [{ action_name: "/fibonacci" }] });

  it("has the gateway's pages and what comes live, each leading to its page", async () => {
    const { asked } = answering({
      "GET /goals?limit=50&cursor=c1": () => ({ goals: [ended("c", -90)], next_cursor: null }),
      "GET /goals": () => ({ goals: [ended("b", -60)], next_cursor: "c1" }),
      "GET /actions": actions,
    });
    const { store, user } = renderPage(fakeGateway(), {}, "/ui/goals");
    await waitFor(() => expect(rows()).toHaveLength(1));
    act(() => store.onEvent(status("a", { action_name: "/fibonacci", created_at: at(0) })));
    await waitFor(() => expect(rows()[0]?.textContent).toMatch(/\/fibonacci.*executing/));
    await user.click(button("Load older goals"));
    await waitFor(() => expect(rows()).toHaveLength(3));
    expect(
      within(rows()[2] as HTMLElement)
        .getByRole("link")
        .getAttribute("href"),
    ).toBe("/ui/goals/c");
    expect(screen.queryByRole("button", { name: "Load older goals" })).toBeNull();
    expect(screen.getByText("3 goals, live")).toBeDefined();
    expect(asked()).toContain("GET /goals?limit=50&cursor=c1");
  });

  it("is narrowed by the address, and the files are, too", async () => {
    const { asked } = answering({
      "GET /goals": () => ({ goals: [ended("b", -60, { status: "aborted" })], next_cursor: null }),
      "GET /actions": actions,
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals?action=%2Fdock&status=aborted");
    await waitFor(() => expect(rows()).toHaveLength(1));
    expect(asked()).toContain("GET /goals?action=%2Fdock&status=aborted&limit=50");
    expect(screen.getByRole("link", { name: /Export CSV/ }).getAttribute("href")).toBe(
      "/goals/export?format=csv&action=%2Fdock&status=aborted",
    );
    expect(screen.getByRole<HTMLInputElement>("checkbox", { name: "Aborted" }).checked).toBe(true);
    await user.selectOptions(screen.getByLabelText("Origin"), "external");
    await waitFor(() =>
      expect(asked()).toContain("GET /goals?action=%2Fdock&status=aborted&origin=external&limit=50"),
    );
    expect(await screen.findByText("No goal fits")).toBeDefined();
    await user.click(button("Show all goals"));
    await waitFor(() => expect(asked()).toContain("GET /goals?limit=50"));
  });

  it("teaches how to send the first goal", async () => {
    answering({ "GET /goals": () => ({ goals: [], next_cursor: null }), "GET /actions": actions });
    renderPage(fakeGateway(), {}, "/ui/goals");
    expect(await screen.findByText("No goals yet")).toBeDefined();
    expect(screen.getByText(/^curl -X POST .*\/dock$/)).toBeDefined();
  });

  it("says why it is not there, and tries again when asked", async () => {
    let works = false;
    const { fetch } = answering({ "GET /actions": actions });
    renderPage(fakeGateway(), {}, "/ui/goals");
    expect(await screen.findByText(/The list of goals could not be loaded/)).toBeDefined();
    works = true;
    fetch.mockImplementation(async () =>
      Response.json(works ? { goals: [ended("a", -9)], next_cursor: null } : null),
    );
    await act(async () => button("Try again").click());
    await waitFor(() => expect(rows()).toHaveLength(1));
  });
});

describe("the page of a goal", () => {
  const schemas = () => ({ type: "t", goal: {}, result: {}, feedback: {} });
  const connect = (goals: LiveGoal[]) => {
    tell(snapshot({ goals: goals as never }));
    act(() => streams[0]?.handlers.onConnection({ kind: "snapshot" }));
  };

  it("shows a running goal as it goes on, to its end", async () => {
    const running = goal("a", {
      created_at: at(-5),
      updated_at: at(-5),
      goal: { desired_battery_state: battery },
    });
    const before = [status("a", { stage: "CONTROLLING" }), feedback("a")];
    const { asked } = answering({
      "GET /goals/a/history": () => ({ events: before, next_after: null, complete: true }),
      "GET /goals/a": () => running,
      "GET /interfaces": schemas,
    });
    renderPage(fakeGateway(), {}, "/ui/goals/a");
    expect((await screen.findByTestId("goal-status")).textContent).toBe("executing");
    expect(streams.map(({ url }) => url)).toEqual([expect.stringMatching(/\/ws\/feedback\?goal_id=a$/)]);
    expect(asked()).not.toContain("GET /goals/a/history?limit=2000");
    connect([running]);
    expect(await screen.findByText("Controlling")).toBeDefined();
    expect(screen.getByText("The goal has not ended.")).toBeDefined();
    await waitFor(() => expect(screen.getByTestId("feedback-count").textContent).toBe("1 message"));
    tell(feedback("a"));
    await waitFor(() => expect(screen.getByTestId("feedback-count").textContent).toBe("2 messages"));
    expect(
      await screen.findByText(/current_battery_state.voltage over time, between 2.16 and 2.16/),
    ).toBeDefined();
    tell(result("a"));
    await waitFor(() => expect(screen.getByTestId("goal-status").textContent).toBe("succeeded"));
    expect(within(screen.getByTestId("timeline")).getByText("succeeded")).toBeDefined();
    expect(screen.getByText("final_battery_state")).toBeDefined();
    expect(document.title).toBe("succeeded: Dock · dock-gateway");
  });

  it("says what to do about an error, and names what is not known of an external goal", async () => {
    const error = { code: "failed_to_charge", detail: "contact without charge" };
    answering({
      "GET /goals/a/history": () => ({ events: [], next_after: null, complete: false }),
      "GET /goals/a": () => ended("a", -60, { status: "aborted", origin: "external", error }),
    });
    renderPage(fakeGateway(), {}, "/ui/goals/a");
    expect(await screen.findByText(/look at the dock's power/)).toBeDefined();
    expect(screen.getByText("Code: failed_to_charge")).toBeDefined();
    expect(await screen.findByText(/The history no longer reaches back/)).toBeDefined();
    expect(button(/Send again/).ariaDisabled).toBe("true");
    expect(screen.getByText(/The goal's message is missing: ROS does not tell/)).toBeDefined();
    expect(screen.getByRole("link", { name: /Export JSON/ }).getAttribute("href")).toBe(
      "/goals/a/export?format=json",
    );
  });

  it("sends the same goal again once that is confirmed, and leads to the new one", async () => {
    const sent: Promise<unknown>[] = [];
    answering({
      "GET /goals/a/history": () => ({ events: [], next_after: null, complete: true }),
      "GET /goals/a": () => ended("a", -60, { action_name: "/robot1/fibonacci", goal: { order: 7 } }),
      "GET /interfaces": schemas,
      "POST /actions/robot1/fibonacci/goals": (request) => {
        sent.push(request.json());
        return goal("new", { status: "accepted" });
      },
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a");
    await user.click(await screen.findByRole("button", { name: /Send again/ }));
    const dialog = await screen.findByRole("dialog", { name: "Send this goal again?" });
    expect(dialog.textContent).toMatch(/A robot may move.*order 7/);
    expect(sent).toEqual([]);
    await user.click(within(dialog).getByRole("button", { name: "Send again" }));
    const link = await screen.findByRole("link", { name: "Watch the new goal" });
    expect(link.getAttribute("href")).toBe("/ui/goals/new");
    expect(await Promise.all(sent)).toEqual([{ order: 7 }]);
  });

  it("does not send while a stop is latched, and says so", async () => {
    answering({
      "GET /goals/a/history": () => ({ events: [], next_after: null, complete: true }),
      "GET /goals/a": () => ended("a", -60, { goal: {} }),
    });
    renderPage(fakeGateway(), { stop: latched("Ada") }, "/ui/goals/a");
    expect(await screen.findByText("The robot is stopped. Release the stop first.")).toBeDefined();
    expect(button(/Send again/).ariaDisabled).toBe("true");
  });

  it("cancels a goal on any action, and says why where that did not work", async () => {
    const running = goal("a", { action_name: "/fibonacci" });
    answering({
      "GET /goals/a/history": () => ({ events: [], next_after: null, complete: true }),
      "GET /goals/a": () => running,
      "POST /goals/a/cancel": () => ({ ...running, status: "canceling", updated_at: at(1) }),
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a");
    await user.click(await screen.findByRole("button", { name: "Cancel" }));
    await waitFor(() => expect(screen.getByTestId("goal-status").textContent).toBe("canceling"));
    expect(screen.getByText("The goal is being canceled.")).toBeDefined();
  });

  it("has the notes and tags of everybody, and adds to them under a name", async () => {
    const note = { id: "n1", by: "Bob", created_at: at(-30), text: "by a box" };
    let stored = { tags: ["blocked"], notes: [note] };
    let etag = '"1"';
    const sent: unknown[] = [];
    const { asked } = answering({
      "GET /goals/tags": () => ({ tags: ["blocked", "maintenance"] }),
      "POST /goals/a/notes": (request) => {
        request.json().then((body) => sent.push(body));
        const added = { ...note, id: "n2", by: "Ada", text: "gone" };
        stored = { ...stored, notes: [note, added] };
        return added;
      },
      "PUT /goals/a/tags": (request) => {
        if (request.headers.get("If-Match") !== etag) {
          const detail = "it was changed meanwhile";
          return Response.json(
            { status: 412, code: "changed_meanwhile", title: "t", detail },
            { status: 412 },
          );
        }
        request.json().then((body) => sent.push(body));
        stored = { ...stored, tags: ["blocked", "late"] };
        return { tags: stored.tags, etag };
      },
      "GET /goals/a/tags": () => ({ tags: stored.tags, etag }),
      "DELETE /goals/a/notes/n1": () => {
        stored = { ...stored, notes: stored.notes.slice(1) };
      },
      "GET /goals/a/history": () => ({ events: [], next_after: null, complete: true }),
      "GET /goals/a": () => ({ ...ended("a", -60), ...stored }),
      "GET /interfaces": schemas,
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a");
    expect(await screen.findByText("by a box")).toBeDefined();
    const section = within(screen.getByRole("region", { name: "Notes" }));
    expect(button("Add note").ariaDisabled).toBe("true");
    await user.type(section.getByLabelText("New note"), "gone");
    await user.type(section.getByLabelText("Your name"), "Ada");
    await user.click(button("Add note"));
    expect(await section.findByText("as Ada")).toBeDefined();
    expect(await section.findByText("gone", { selector: "p" })).toBeDefined();
    expect(section.getByLabelText<HTMLTextAreaElement>("New note").value).toBe("");
    await user.type(section.getByRole("combobox", { name: "Tags" }), "late{Enter}");
    expect(await section.findByText("late")).toBeDefined();
    expect(sent).toEqual([{ by: "Ada", text: "gone" }, { tags: ["blocked", "late"] }]);
    [stored, etag] = [{ ...stored, tags: ["night"] }, '"2"']; // by someone else
    await user.type(section.getByRole("combobox", { name: "Tags" }), "lost{Enter}");
    expect(await section.findByText("Someone else has changed the tags meanwhile")).toBeDefined();
    expect(await section.findByText("night")).toBeDefined();
    expect(section.queryByText("lost")).toBeNull();
    expect(sent).toHaveLength(2);
    await user.click(button("Delete the note by Bob"));
    expect(asked().some((each) => each.startsWith("DELETE"))).toBe(false);
    await user.click(button("Really delete the note by Bob"));
    await waitFor(() => expect(section.queryByText("by a box")).toBeNull());
    localStorage.clear();
  });

  it("says that there is no such goal", async () => {
    answering({});
    renderPage(fakeGateway(), {}, "/ui/goals/gone");
    expect(await screen.findByText(/the gateway does not know this goal/)).toBeDefined();
    expect(screen.getByText("Code: goal_not_found")).toBeDefined();
  });

  it("tells its feedback row by row, held where somebody reads", async () => {
    const events = Array.from({ length: 30 }, () => feedback("a"));
    answering({
      "GET /goals/a/history": () => ({ events, next_after: null, complete: true }),
      "GET /goals/a": () => goal("a", { feedback_count: 30 }),
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a");
    await screen.findByTestId("goal-status");
    connect([goal("a", { feedback_count: 30 })]);
    const table = await screen.findByTestId("feedback-table");
    const times = () => within(table).getAllByRole("row").length - 1;
    expect(times()).toBe(12);
    await user.click(button("Older"));
    await user.click(button("Older"));
    expect(times()).toBe(6);
    expect(button("Older").disabled).toBe(true);
    await user.click(button("Follow"));
    expect(times()).toBe(12);
    const [first] = within(table).getAllByRole("button");
    if (first === undefined) throw new Error("no row");
    await user.click(first);
    expect(first.getAttribute("aria-pressed")).toBe("true");
    expect(screen.getByRole("heading", { name: /^Message at/ })).toBeDefined();
    await user.click(button("Show the latest"));
    expect(screen.getByRole("heading", { name: "Latest message" })).toBeDefined();
  });

  it("has a table of numbers that stand below each other, of the rows that changed where asked for", async () => {
    const voltages = [9, 9, 9, 8.95, 8.95, 9];
    const events = voltages.map((voltage, index) => ({
      ...feedback("a", index + 0.1234),
      feedback: { current_battery_state: { ...battery, voltage } },
    }));
    answering({
      "GET /goals/a/history": () => ({ events, next_after: null, complete: true }),
      "GET /goals/a": () => ended("a", 0, { created_at: new Date(START).toISOString(), feedback_count: 6 }),
    });
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a?changed=true");
    const table = await screen.findByTestId("feedback-table");
    const cells = () =>
      within(table)
        .getAllByRole("row")
        .slice(1)
        .map((row) => [0, 2].map((index) => row.querySelectorAll("td")[index]?.textContent));
    expect(cells()).toEqual([
      ["5.123 s", "9.00"],
      ["3.123 s", "8.95"],
      ["0.123 s", "9.00"],
    ]);
    expect(table.querySelector("tbody time")?.textContent).toMatch(/:45\.123/);
    expect(screen.getByTestId("changed-count").textContent).toBe("3 of 6");
    await user.click(screen.getByRole("switch", { name: "Only rows that changed" }));
    expect(cells()).toHaveLength(6);
  });

  /** A docking goal of ten seconds with a message each half of a second. */
  const replayed = () => {
    const finished_at = new Date(START + 10_000).toISOString();
    const error = { code: "blocked", detail: "moved 0.01 m in 5 s" };
    const events = [
      status("a", { stage: "NAV_TO_STAGING_POSE" }, 1),
      ...Array.from({ length: 20 }, (_, index) => feedback("a", index / 2)),
      status("a", { stage: "CONTROLLING" }, 4),
      status("a", { status: "aborted", stage: "ABORTED", error, finished_at }, 10),
    ];
    answering({
      "GET /goals/a/history": () => ({ events, next_after: null, complete: true }),
      "GET /goals/a": () => ({
        ...goal("a", { status: "aborted", error, feedback_count: 20, finished_at }),
        created_at: new Date(START).toISOString(),
      }),
    });
  };
  const marked = () => document.querySelector("tr[data-marked] button")?.textContent;

  it("has its verdict first: what became of it, why, for how long, and what to do", async () => {
    replayed();
    renderPage(fakeGateway(), {}, "/ui/goals/a");
    const verdict = await screen.findByTestId("verdict");
    expect(verdict.textContent).toMatch(
      /^Docking failed: robot was blocked, after 10 sWhat to do: Look at the robot.*Code: blocked$/,
    );
    expect(verdict.dataset.tone).toBe("bad");
  });

  it("is replayed at the moment that the address holds: row, message and stage", async () => {
    replayed();
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a?at=3.2");
    const scrubber = await screen.findByRole<HTMLInputElement>("slider", { name: "Moment of the goal" });
    await screen.findByTestId("feedback-table");
    expect(scrubber.getAttribute("aria-valuetext")).toBe("3.2 s, Staging");
    expect(marked()).toBe("3.000 s");
    expect(screen.getByRole("heading", { name: "Message at 3.000 s" })).toBeDefined();
    const entry = () => screen.getByTestId("timeline").querySelector("[data-marked]")?.textContent;
    expect(entry()).toMatch(/^Staging/);
    fireEvent.change(scrubber, { target: { value: "9" } });
    expect(screen.getByTestId("replay-moment").textContent).toBe("9.0 s, Controlling");
    expect([marked(), entry()]).toEqual(["9.000 s", expect.stringMatching(/^Controlling/)]);
    await user.click(button("End replay"));
    expect(screen.getByRole("heading", { name: "Latest message" })).toBeDefined();
    expect(marked()).toBeUndefined();
  });

  it("plays to its end, and from its beginning again", async () => {
    replayed();
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a?at=9.9");
    await screen.findByTestId("feedback-table");
    await user.click(button("Play"));
    await waitFor(() => expect(screen.getByTestId("replay-moment").textContent).toBe("10.0 s"));
    await waitFor(() => expect(button("Play")).toBeDefined());
    await user.click(button("Play"));
    await waitFor(() => expect(screen.getByTestId("replay-moment").textContent).toMatch(/^[0-9]\.[0-9] s/));
    await user.click(button("Pause"));
  });

  it("marks one moment in the table and on the plots, and shows the message that a plot was clicked at", async () => {
    replayed();
    const { user } = renderPage(fakeGateway(), {}, "/ui/goals/a");
    const table = await screen.findByTestId("feedback-table");
    const row = within(table).getByRole("button", { name: "8.000 s" });
    await user.hover(row);
    expect(marked()).toBe("8.000 s");
    await user.unhover(row);
    await user.hover(document.body);
    expect(marked()).toBeUndefined();
    await user.click(button(/^current_battery_state.voltage over time/));
    expect(screen.getByRole("heading", { name: "Message at 3.000 s" })).toBeDefined();
    // It is among the rows, which were those from 4 s on.
    expect(within(table).getByRole("button", { name: "3.000 s", pressed: true })).toBeDefined();
  });

  it("plots several quantities, those that the address names", async () => {
    replayed();
    const names = ["voltage", "percentage"].map((name) => `plot=current_battery_state.${name}`);
    const { user } = renderPage(fakeGateway(), {}, `/ui/goals/a?${names.join("&")}`);
    const plots = () =>
      screen.getAllByText(/ over time, between /).map(({ textContent }) => textContent?.split(" ")[0]);
    await screen.findByTestId("feedback-table");
    await waitFor(() =>
      expect(plots()).toEqual(["current_battery_state.voltage", "current_battery_state.percentage"]),
    );
    await user.selectOptions(
      screen.getByLabelText("Add a plot"),
      "current_battery_state.power_supply_status",
    );
    expect(plots()).toHaveLength(3);
    await user.click(button("Remove the plot of current_battery_state.voltage"));
    expect(plots()).toEqual([
      "current_battery_state.percentage",
      "current_battery_state.power_supply_status",
    ]);
  });
});
