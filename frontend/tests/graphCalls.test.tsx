import { screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";
import type { ParameterInfo } from "../src/api/calls";
import { ServiceCall, TopicPublish } from "../src/graph/calls";
import { NodeParameters } from "../src/graph/NodeParameters";
import { latched } from "./events";
import { topic } from "./graph";
import { descriptionOf, fakeGateway, renderWithin, robotServices } from "./page";

const ALLOWED = { allowed: true, reason: null };
const SERVICE = {
  service: "/robot1/echo",
  type: "std_srvs/srv/SetBool",
  types: ["std_srvs/srv/SetBool"],
  reads: false,
  hint: null,
  call: ALLOWED,
  request: { type: "object", properties: { data: { type: "boolean", default: false } } },
  response: { type: "object", properties: { success: { type: "boolean" } } },
};
const TOPIC = {
  topic: "/robot1/chatter",
  type: "std_msgs/msg/String",
  types: ["std_msgs/msg/String"],
  reports: false,
  hint: null,
  publish: ALLOWED,
  message: { type: "object", properties: { data: { type: "string", default: "" } } },
};
const service = { name: "/robot1/echo", types: SERVICE.types, servers: ["/robot1/base"], hidden: false };

function parameter(
  name: string,
  type: string,
  value: unknown,
  change: Partial<ParameterInfo> = {},
): ParameterInfo {
  const said = { description: "", constraints: "", read_only: false, dynamic_typing: false, range: null };
  return { name, type, value, ...said, ...change };
}

const PARAMETERS = [
  parameter("limit", "integer", "9223372036854775807"),
  parameter("FollowPath.speed", "double", 0.5, { range: { minimum: 0, maximum: 1, step: 0 } }),
  parameter("fixed", "string", "as it is", { read_only: true }),
  parameter("raw", "byte array", [0, 255]),
];

/** A gateway's HTTP; remembers what was sent. */
function answering(answers: Record<string, { status?: number; body: unknown }>) {
  const sent: { request: string; body: string }[] = [];
  vi.stubGlobal(
    "fetch",
    vi.fn(async (request: Request) => {
      const { pathname } = new URL(request.url);
      const name = `${request.method} ${pathname}`;
      if (request.method !== "GET") sent.push({ request: name, body: await request.text() });
      const { status = 200, body } = answers[name] ?? {
        status: 404,
        body: { code: "not_found", detail: name },
      };
      return Response.json(body, { status });
    }),
  );
  return sent;
}

function render(children: React.ReactNode, first: Parameters<typeof robotServices>[1] = {}) {
  renderWithin(robotServices(fakeGateway(), first).fleet, children);
  return userEvent.setup({ delay: null, pointerEventsCheck: 0 });
}

describe("a service", () => {
  it("is called once it was asked, and its answer is shown", async () => {
    const sent = answering({
      "GET /services/robot1/echo": { body: SERVICE },
      "POST /services/robot1/echo": { body: { service: "", type: "", response: { success: true } } },
    });
    const user = render(<ServiceCall service={service} />);
    await user.click(await screen.findByRole("switch", { name: "data" }));
    await user.click(screen.getByRole("button", { name: "Call the service …" }));
    expect(sent).toEqual([]);
    await user.click(
      within(await screen.findByRole("dialog")).getByRole("button", { name: "Call the service" }),
    );
    await screen.findByText("success");
    expect(sent).toEqual([{ request: "POST /services/robot1/echo", body: '{"data": true}' }]);
  });

  it("that the settings do not name has no form, but the sentence why", async () => {
    const reason =
      "the gateway does not call the service /robot1/echo: start it with --allow-services '/robot1/echo'";
    answering({ "GET /services/robot1/echo": { body: { ...SERVICE, call: { allowed: false, reason } } } });
    render(<ServiceCall service={service} />);
    await screen.findByText(/^The gateway does not call .*--allow-services/);
    expect(screen.queryByRole("button")).toBeNull();
  });

  it("of a stopped robot is not called", async () => {
    answering({ "GET /services/robot1/echo": { body: SERVICE } });
    render(<ServiceCall service={service} />, { stop: latched("Ann") });
    const button = await screen.findByRole("button", { name: "Call the service …" });
    expect(descriptionOf(button)).toBe("The robot is stopped. Release the stop first.");
  });
});

describe("a topic", () => {
  it("gets a message, and says how many hear it", async () => {
    const sent = answering({
      "GET /topics/robot1/chatter": { body: TOPIC },
      "POST /topics/robot1/chatter": { body: { topic: "", type: "", subscribers: 2, message: {} } },
    });
    const user = render(<TopicPublish topic={topic("/robot1/chatter")} />);
    await user.type(await screen.findByLabelText("data"), "hello");
    await user.click(screen.getByRole("button", { name: "Publish the message …" }));
    await user.click(
      within(await screen.findByRole("dialog")).getByRole("button", { name: "Publish the message" }),
    );
    await screen.findByText("Published. It went to 2 subscribers.");
    expect(sent).toEqual([{ request: "POST /topics/robot1/chatter", body: '{"data": "hello"}' }]);
  });
});

describe("parameters", () => {
  const PATH = "/nodes/robot1/base/parameters";
  const answer = (parameters = PARAMETERS) => ({ body: { node: "/robot1/base", set: ALLOWED, parameters } });

  it("are read when they are asked for, and only what was changed is set", async () => {
    const sent = answering({ [`GET ${PATH}`]: answer(), [`PATCH ${PATH}`]: { body: answer().body } });
    const user = render(<NodeParameters node="/robot1/base" />);
    await user.click(screen.getByRole("button", { name: "Read the parameters" }));
    const limit = await screen.findByLabelText("limit");
    expect((limit as HTMLInputElement).value).toBe("9223372036854775807");
    screen.getByText("as it is");
    expect(screen.queryByLabelText("fixed")).toBeNull();
    await user.clear(limit);
    await user.type(limit, "9007199254740993");
    await user.click(screen.getByRole("button", { name: "Set the parameter" }));
    await waitFor(() =>
      expect(sent).toEqual([{ request: `PATCH ${PATH}`, body: '{"limit": "9007199254740993"}' }]),
    );
  });

  it("that the gateway refuses are marked", async () => {
    const detail = "FollowPath.speed: expected 0 to 1, got 7";
    const errors = [{ path: "FollowPath.speed", expected: "0 to 1", detail: "got 7" }];
    const refused = {
      type: "about:blank",
      title: "Invalid field",
      status: 422,
      code: "invalid_field",
      detail,
      errors,
    };
    answering({ [`GET ${PATH}`]: answer(), [`PATCH ${PATH}`]: { status: 422, body: refused } });
    const user = render(<NodeParameters node="/robot1/base" />);
    await user.click(screen.getByRole("button", { name: "Read the parameters" }));
    const speed = await screen.findByLabelText("FollowPath.speed");
    await user.clear(speed);
    await user.type(speed, "7");
    await user.click(screen.getByRole("button", { name: "Set the parameter" }));
    await screen.findByText("expected 0 to 1, got 7");
    expect(speed.getAttribute("aria-invalid")).toBe("true");
    expect((speed as HTMLInputElement).value).toBe("7");
  });
});
