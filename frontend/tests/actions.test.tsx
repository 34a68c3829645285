import { EditorView } from "@codemirror/view";
import type { ActionInfo, LiveGoal } from "@dock-gateway/client";
import { act, screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { at, feedback, fibonacciAction, goal, latched, result, status } from "./events";
import schemas from "./form/schemas.json";
import { descriptionOf, fakeGateway, pressEscape, renderPage } from "./page";
import { streams } from "./streams";

const TYPES = "action_tutorials_interfaces/action";
const fibonacci = fibonacciAction("/robot1/fibonacci");
const dock: ActionInfo = {
  ...fibonacci,
  action_name: "/dock",
  action_type: `${TYPES}/ConnectToChargingDock`,
  verb: "dock",
};
const spin: ActionInfo = {
  ...fibonacci,
  action_name: "/spin",
  action_type: "nav2_msgs/action/Spin",
  installed: false,
  answering: false,
  hint: "install the Python package of the ROS interfaces nav2_msgs (such as ros-nav2-msgs)",
};
const arrays = { ...fibonacci, action_name: "/arrays", action_type: "test_msgs/msg/BoundedSequences" };

type Answer = { status?: number; body: unknown };

/** A gateway's HTTP; remembers what was sent. */
function answering(actions: ActionInfo[], answers: Record<string, () => Answer> = {}) {
  const sent: { path: string; body: string }[] = [];
  vi.stubGlobal(
    "fetch",
    vi.fn(async (request: Request) => {
      const { pathname } = new URL(request.url);
      const body = await request.text();
      if (request.method === "POST") sent.push({ path: pathname, body });
      const answer =
        answers[`${request.method} ${pathname}`]?.() ?? standard(pathname, request.method, actions);
      return Response.json(answer.body, { status: answer.status ?? 200 });
    }),
  );
  return sent;
}

function standard(path: string, method: string, actions: ActionInfo[]): Answer {
  if (path === "/actions") return { body: { actions } };
  if (path === "/goals") return { body: { goals: [], next_cursor: null } };
  if (path.startsWith("/interfaces/")) {
    const type = path.replace("/interfaces/", "");
    const schema = (schemas as Record<string, unknown>)[type.replace("/action/Bounded", "/msg/Bounded")];
    return { body: { type, goal: schema, result: {}, feedback: {} } };
  }
  if (method === "POST") {
    const name = path.replace(/^\/actions/, "").replace(/\/goals$/, "");
    return {
      status: 202,
      body: goal("sent1234", { action_name: name, created_at: at(100), status: "accepted" }),
    };
  }
  return { status: 404, body: { code: "not_found", title: "Not found", status: 404, detail: path } };
}

const openFibonacci = () => renderPage(fakeGateway(), {}, "/ui/actions/robot1/fibonacci");
const field = (name: string) => screen.findByRole("textbox", { name });
const jsonEditor = () =>
  waitFor(() => {
    const view = EditorView.findFromDOM(screen.getByRole("textbox", { name: "Goal message as JSON" }));
    if (view === null) throw new Error("the editor is not loaded");
    return view;
  });
/** jsdom has no layout, which typing into the editor needs. */
const write = (editor: EditorView, insert: string) =>
  act(() => editor.dispatch({ changes: { from: 0, to: editor.state.doc.length, insert } }));
const press = (name: string) => screen.getByRole("button", { name });

beforeEach(() => localStorage.clear());

describe("the actions", () => {
  it("are listed with their servers, goals, and what is to be installed", async () => {
    const twice = { ...fibonacci, action_name: "/twice", duplicate: true };
    answering([fibonacci, spin, twice, { ...dock, answering: false }]);
    const running = goal("a", { action_name: "/dock" });
    renderPage(fakeGateway(), { goals: [running] }, "/ui/actions");
    const row = async (name: string) =>
      within((await screen.findByRole("link", { name })).closest("tr") as HTMLElement);
    expect((await row("/robot1/fibonacci")).getByText("answering")).toBeDefined();
    expect((await row("/spin")).getByText(/^Install the Python package/)).toBeDefined();
    expect((await row("/spin")).getByText("package missing")).toBeDefined();
    expect((await row("/dock")).getByText("silent")).toBeDefined();
    expect((await row("/twice")).getByText("two servers")).toBeDefined();
    expect((await row("/dock")).getByText("executing")).toBeDefined();
    expect(screen.getByRole("link", { name: "/robot1/fibonacci" }).getAttribute("href")).toBe(
      "/ui/actions/robot1/fibonacci",
    );
  });

  it("are searched for by name and type", async () => {
    answering([fibonacci, spin, dock]);
    renderPage(fakeGateway(), {}, "/ui/actions?q=nav2");
    await screen.findByRole("link", { name: "/spin" });
    expect(screen.queryByRole("link", { name: "/dock" })).toBeNull();
    expect(screen.getByText("1 of 3")).toBeDefined();
  });

  it("teach what to start where there is none to try", async () => {
    answering([dock]);
    renderPage(fakeGateway(), {}, "/ui/actions");
    expect(await screen.findByText("fibonacci_action_server")).toBeDefined();
    expect(screen.getByText(/curl -sX POST .*\/actions\/fibonacci\/goals/)).toBeDefined();
  });

  it("are not there while the gateway does not answer, which is said", async () => {
    answering([], {
      "GET /actions": () => ({ status: 503, body: { code: "ros_unavailable", title: "", detail: "" } }),
    });
    renderPage(fakeGateway(), {}, "/ui/actions");
    expect(await screen.findByText(/gateway has lost ROS/)).toBeDefined();
  });
});

describe("a goal of any action", () => {
  it("is sent without a question where nothing moves, exactly as the command line says", async () => {
    const sent = answering([fibonacci]);
    const { user } = openFibonacci();
    const order = await field("order");
    expect(screen.getByText(/-d '\{"order": 10\}'$/)).toBeDefined();
    await user.clear(order);
    await user.type(order, "7{Enter}");
    expect(await screen.findByText(/took/)).toBeDefined();
    expect(sent).toEqual([{ path: "/actions/robot1/fibonacci/goals", body: '{"order": 7}' }]);
    expect(screen.getByText(/-d '\{"order": 7\}'$/)).toBeDefined();
    expect(screen.getByRole("link", { name: "goal sent1234" }).getAttribute("href")).toBe(
      "/ui/goals/sent1234",
    );
    await waitFor(() => expect(streams.map(({ url }) => url)).toEqual([expect.stringContaining("sent1234")]));
  });

  it("is asked about where a robot may move, once, and never again where somebody wishes so", async () => {
    const sent = answering([dock]);
    const { user } = renderPage(fakeGateway(), {}, "/ui/actions/dock");
    await user.click(await screen.findByRole("button", { name: "Send goal …" }));
    const question = within(await screen.findByRole("dialog", { name: "Send this goal?" }));
    expect(question.getByText('{"desired_battery_state": {"power_supply_status": 1}}')).toBeDefined();
    expect(document.activeElement?.textContent).toBe("Do not send");
    await user.click(question.getByRole("checkbox", { name: /Do not ask again/ }));
    await user.click(question.getByRole("button", { name: "Send the goal" }));
    await waitFor(() => expect(sent).toHaveLength(1));
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    await user.click(await screen.findByRole("button", { name: "Send goal" }));
    await waitFor(() => expect(sent).toHaveLength(2));
    await user.click(press("Ask again before sending"));
    expect(press("Send goal …")).toBeDefined();
  });

  it("is not sent with a wrong value; that gets the focus, also out of a fold", async () => {
    const sent = answering([dock]);
    const { user } = renderPage(fakeGateway(), {}, "/ui/actions/dock");
    await user.click(await screen.findByText("header"));
    await user.click(await screen.findByText("stamp"));
    await user.type(await field("sec"), "x");
    await user.click(screen.getByText("desired_battery_state"));
    expect(screen.queryByRole("textbox", { name: "sec" })).toBeNull();
    expect(screen.getByText("1 not valid")).toBeDefined();
    await user.click(press("Send goal …"));
    const sec = await field("sec");
    await waitFor(() => expect(document.activeElement).toBe(sec));
    expect(sec.getAttribute("aria-invalid")).toBe("true");
    expect(sent).toEqual([]);
  });

  it("shows at the field what the gateway refuses", async () => {
    const problem = {
      code: "invalid_field",
      title: "Invalid field",
      status: 422,
      detail: "order: expected at most 46, got 99",
      errors: [{ path: "order", expected: "at most 46", detail: "got 99" }],
    };
    answering([fibonacci], {
      "POST /actions/robot1/fibonacci/goals": () => ({ status: 422, body: problem }),
    });
    const { user } = openFibonacci();
    const order = await field("order");
    await user.click(press("Send goal"));
    await waitFor(() => expect(order.getAttribute("aria-invalid")).toBe("true"));
    expect(screen.getByText("expected at most 46, got 99")).toBeDefined();
    expect(screen.getByText(/Send goal did not work: a value is not valid/)).toBeDefined();
    await user.type(order, "1");
    expect(order.getAttribute("aria-invalid")).not.toBe("true");
  });

  it("is written as JSON, too, and stays JSON where the form cannot show it", async () => {
    const sent = answering([fibonacci]);
    const { user } = openFibonacci();
    await field("order");
    await user.click(screen.getByRole("radio", { name: "JSON" }));
    const editor = await jsonEditor();
    expect(editor.state.doc.toString()).toBe('{\n  "order": 10\n}');
    expect(descriptionOf(editor.contentDOM)).toMatch(/^Fields that are left out/);
    write(editor, '{"ordre": 3}');
    expect(editor.contentDOM.getAttribute("aria-invalid")).toBe("true");
    await user.click(screen.getByRole("radio", { name: "Form" }));
    expect(screen.getByText("The form cannot show this:")).toBeDefined();
    expect(screen.getByText("ordre:", { exact: false })).toBeDefined();
    write(editor, '{ "order":3 }');
    expect(editor.contentDOM.getAttribute("aria-invalid")).toBe("false");
    await user.click(press("Send goal"));
    await waitFor(() => expect(sent.map(({ body }) => body)).toEqual(['{ "order":3 }']));
    await user.click(screen.getByRole("radio", { name: "Form" }));
    expect(((await field("order")) as HTMLInputElement).value).toBe("3");
  });

  it("as JSON stops every robot at Escape twice, and follows Reset", async () => {
    answering([fibonacci]);
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, {}, "/ui/actions/robot1/fibonacci");
    await field("order");
    await user.click(screen.getByRole("radio", { name: "JSON" }));
    const editor = await jsonEditor();
    await user.click(screen.getByText("Goal message as JSON"));
    expect(document.activeElement).toBe(editor.contentDOM);
    pressEscape(1000);
    pressEscape(1200);
    await waitFor(() => expect(gateway.stop).toHaveBeenCalledTimes(1));
    await user.click(press("Reset"));
    expect(editor.state.doc.toString()).toBe("{}");
  });

  it("has lists that grow to their bound and shrink, by keyboard", async () => {
    answering([{ ...arrays, action_type: "test_msgs/action/BoundedSequences" }]);
    const { user } = renderPage(fakeGateway(), {}, "/ui/actions/arrays");
    const list = within(await screen.findByRole("group", { name: "string_values" }));
    const add = list.getByRole<HTMLButtonElement>("button", { name: "Add to string_values" });
    add.focus();
    await user.keyboard("{Enter}{Enter}{Enter}");
    expect(add.disabled).toBe(true);
    expect(list.getByText("No more fit in.")).toBeDefined();
    await user.type(list.getByRole("textbox", { name: "string_values 2" }), "b");
    await user.click(list.getByRole("button", { name: "Remove string_values 1" }));
    expect(screen.getByText(/"string_values": \["b", ""\]/)).toBeDefined();
    await user.click(screen.getByText("Reset"));
    expect(screen.getByText(/-d '\{\}'$/)).toBeDefined();
  });

  it("is not sent while it cannot be, and the page says why", async () => {
    answering([fibonacci]);
    const { store } = renderPage(fakeGateway(), { stop: latched("Ada") }, "/ui/actions/robot1/fibonacci");
    await field("order");
    expect(press("Send goal").hasAttribute("disabled")).toBe(true);
    expect(screen.getByText("The robot is stopped. Release the stop first.")).toBeDefined();
    act(() => store.onConnection({ kind: "closed" }));
    expect(await screen.findAllByText("The gateway is not connected.")).not.toEqual([]);
  });

  it("keeps the form when the action server goes, and says what to do where there was none", async () => {
    const actions = [fibonacci];
    answering(actions);
    openFibonacci();
    await field("order");
    actions.pop();
    expect(await screen.findByText(/No action server for this action/)).toBeDefined();
    expect(screen.getByRole("textbox", { name: "order" })).toBeDefined();
  });

  it("has no form where the package is missing", async () => {
    answering([spin]);
    renderPage(fakeGateway(), {}, "/ui/actions/spin");
    expect(
      await screen.findByText(/Install the Python package of .*nav2_msgs.*where the gateway runs/),
    ).toBeDefined();
  });

  it("of an action that is not there is a page that says so", async () => {
    answering([]);
    renderPage(fakeGateway(), {}, "/ui/actions/no/such");
    expect(await screen.findByText("No action server for /no/such")).toBeDefined();
  });
});

describe("the goal to watch", () => {
  const action_name = "/robot1/fibonacci";

  it("shows the sequence as it grows, its result, and can be canceled", async () => {
    const sent = answering([fibonacci], {
      "POST /goals/a/cancel": () => ({ status: 202, body: goal("a", { action_name, status: "canceling" }) }),
    });
    const { store, user } = renderPage(
      fakeGateway(),
      { goals: [goal("a", { action_name })] },
      "/ui/actions/robot1/fibonacci",
    );
    await screen.findByRole("region", { name: "Running goal" });
    const grow = (partial_sequence: number[]) =>
      act(() => store.onEvent({ ...feedback("a"), feedback: { partial_sequence } } as never));
    grow([0, 1, 1]);
    grow([0, 1, 1, 2, 3]);
    const list = await screen.findByRole("list", { name: "partial_sequence" });
    await waitFor(() => expect(list.textContent).toBe("01123"));
    await user.click(press("Cancel"));
    expect(sent.map(({ path }) => path)).toContain("/goals/a/cancel");
    act(() => {
      store.onEvent(status("a", { action_name, status: "succeeded", finished_at: at(5) }, 5));
      store.onEvent(result("a", { result: { sequence: [0, 1, 1, 2, 3, 5] } } as never, 5));
    });
    await screen.findByRole("region", { name: "Last goal" });
    expect((await screen.findByRole("list", { name: "sequence" })).textContent).toBe("011235");
  });

  it("is followed by those of the past, which can be filled in again", async () => {
    const past = goal("b", { action_name, status: "succeeded", finished_at: at(3) });
    answering([fibonacci]);
    const { user } = renderPage(
      fakeGateway(),
      { goals: [{ ...past, goal: { order: 21 } } as unknown as LiveGoal] },
      "/ui/actions/robot1/fibonacci",
    );
    await field("order");
    expect(screen.getByText('{"order": 21}')).toBeDefined();
    await user.click(press("Reuse"));
    expect(((await field("order")) as HTMLInputElement).value).toBe("21");
  });
});
