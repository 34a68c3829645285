import { readFileSync } from "node:fs";
import { act, screen, waitFor } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import "../src/access/AccountMenu";
import "../src/access/LoginForm";
import "../src/access/LoginPage";
import "../src/access/TokensPage";
import { NEEDED, whyForbidden } from "../src/access/permissions";
import { ANYBODY, type Role, Session, type SessionState, session } from "../src/access/session";
import type { Token } from "../src/api/access";
import { whyNot } from "../src/operations/operation";
import { ownName, setOwnName } from "../src/stop/who";
import { robot } from "./events";
import { descriptionOf, fakeGateway, isDisabled, renderPage } from "./page";

const OUT: SessionState = { required: true, principal: null };
const as = (role: Role, name = "Ada"): SessionState => ({
  required: true,
  principal: { name, kind: "token", role, robots: [], actions: [], topics: [] },
});

const NIGHT: Token = {
  id: "0123456789abcdef",
  name: "Night shift",
  role: "operator",
  robots: ["/hall_a/*"],
  actions: [],
  topics: [],
  created_by: "Ada",
  created_at: "2026-11-23T09:00:00Z",
  expires_at: null,
  used_at: null,
  valid: true,
};

/** A gateway with one valid token, `dgw_right`, and a list of tokens; it remembers what it is asked. */
function answering(tokens: Token[] = []) {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request | string) => {
    if (typeof request === "string") return Response.json(session.state);
    const { pathname } = new URL(request.url);
    asked.push(`${request.method} ${pathname}`);
    if (pathname === "/session" && request.method === "POST") {
      const { token } = (await request.json()) as { token: string };
      if (token === "dgw_right") return Response.json(as("operator"));
      return Response.json({ code: "invalid_token", title: "No", detail: "no" }, { status: 401 });
    }
    if (pathname === "/tokens" && request.method === "GET") return Response.json({ tokens });
    if (pathname === "/tokens") {
      const body = (await request.json()) as Pick<Token, "name" | "role">;
      const created = { ...NIGHT, ...body, id: "f".repeat(16) };
      tokens = [...tokens, created];
      return Response.json({ ...created, secret: "dgw_new" }, { status: 201 });
    }
    if (request.method === "DELETE") {
      tokens = tokens.filter(({ id }) => !pathname.endsWith(id));
      return new Response(null, { status: 204 });
    }
    return Response.json({}, { status: 404 });
  });
  return asked;
}

beforeEach(() => session.set(ANYBODY));

describe("permissions", () => {
  it("are those of the gateway", () => {
    const { paths } = JSON.parse(readFileSync("openapi.json", "utf8"));
    const roles = Object.keys(NEEDED).map((command) => {
      const [method = "", path = ""] = command.split(" ");
      return [command, paths[path][method.toLowerCase()]["x-role"]];
    });
    expect(Object.fromEntries(roles)).toEqual(NEEDED);
  });

  it("say what role something needs", () => {
    expect(whyForbidden("DELETE /stop")).toBeNull();
    session.set(as("operator"));
    expect(whyForbidden("POST /dock")).toBeNull();
    expect(whyForbidden("DELETE /stop")).toBe("Needs the role supervisor; you are operator.");
    session.set(OUT);
    expect(whyForbidden("POST /dock")).toBe("Your login has ended. Log in first.");
  });

  it("hold for commands from every page, and never for Stop", () => {
    session.set(as("viewer"));
    for (const operation of ["dock", "undock", "cancel"] as const)
      expect(whyNot(operation, robot("/robot1"), true)).toBe("Needs the role operator; you are viewer.");
    expect(whyNot("stop", robot("/robot1"), true)).toBeNull();
  });
});

describe("the session", () => {
  it("lets wait until somebody has logged in", async () => {
    const own = new Session();
    await own.loggedIn();
    own.set(OUT);
    const entered = vi.fn();
    const waiting = own.loggedIn().then(entered);
    own.set({ ...OUT });
    await Promise.resolve();
    expect(entered).not.toHaveBeenCalled();
    own.set(as("viewer"));
    await waiting;
    expect(entered).toHaveBeenCalledOnce();
  });

  it("asks once at a time, and stays as it was without an answer", async () => {
    const own = new Session();
    const fetching = vi.fn(async () => Response.json(OUT));
    vi.stubGlobal("fetch", fetching);
    await Promise.all([own.ask(), own.ask()]);
    expect(fetching).toHaveBeenCalledOnce();
    expect(own.loggedOut).toBe(true);
    vi.stubGlobal("fetch", async () => Promise.reject(new TypeError("refused")));
    await own.ask();
    expect(own.loggedOut).toBe(true);
  });

  it("names who does something, whatever name this browser keeps", () => {
    setOwnName("Bob");
    expect(ownName()).toBe("Bob");
    session.set(as("operator"));
    setOwnName("Eve");
    expect(ownName()).toBe("Ada");
    session.set(ANYBODY);
    expect(ownName()).toBe("Bob");
    setOwnName("");
  });
});

describe("the page", () => {
  it("has nothing of a login where none is needed", async () => {
    answering();
    renderPage(fakeGateway());
    expect(await screen.findByRole("button", { name: "Dock" })).toBeDefined();
    expect(screen.queryByRole("button", { name: /Logged in/ })).toBeNull();
  });

  it("asks for a token first, says what is wrong with it, and then shows the page", async () => {
    answering();
    session.set(OUT);
    const { user } = renderPage(fakeGateway());
    const field = await screen.findByLabelText("Token");
    expect(document.activeElement).toBe(field);
    expect(screen.queryByRole("button", { name: "Stop" })).toBeNull();
    await user.keyboard("{Enter}");
    expect(await screen.findByText("Enter your token.")).toBeDefined();
    await user.paste("dgw_wrong");
    await user.keyboard("{Enter}");
    expect(await screen.findByText(/This token is not valid/)).toBeDefined();
    await user.clear(field);
    await user.paste(" dgw_right ");
    await user.keyboard("{Enter}");
    expect(await screen.findByRole("button", { name: "Logged in as Ada, operator" })).toBeDefined();
    expect(isDisabled("Dock")).toBe(false);
  });

  it("says what a viewer may not do, and keeps Stop", async () => {
    answering();
    session.set(as("viewer"));
    renderPage(fakeGateway());
    const dock = await screen.findByRole("button", { name: "Dock" });
    expect(isDisabled("Dock")).toBe(true);
    expect(descriptionOf(dock)).toBe("Needs the role operator; you are viewer.");
    expect(isDisabled("Stop")).toBe(false);
  });

  it("stays when the login ends, and goes on after another one", async () => {
    answering();
    session.set(as("operator"));
    const { user } = renderPage(fakeGateway());
    await screen.findByRole("button", { name: "Dock" });
    act(() => session.set(OUT));
    expect(await screen.findByText("Your login has ended")).toBeDefined();
    expect(screen.getByTestId("connection").textContent).toBe("logged out");
    expect(isDisabled("Dock")).toBe(true);
    expect(isDisabled("Stop")).toBe(false);
    await user.click(screen.getByRole("button", { name: "Log in …" }));
    await user.click(await screen.findByLabelText("Token"));
    await user.paste("dgw_right");
    await user.keyboard("{Enter}");
    await waitFor(() => expect(screen.queryByText("Your login has ended")).toBeNull());
    expect(isDisabled("Dock")).toBe(false);
  });

  it("has tokens for admins: creates one, shows its secret once, and revokes it", async () => {
    const asked = answering([NIGHT]);
    session.set(as("admin"));
    const { user } = renderPage(fakeGateway(), {}, "/ui/tokens");
    expect((await screen.findByRole("listitem", { name: "Night shift" })).textContent).toMatch(
      /operator.*Created.*by Ada.*Expires.*Never.*Last used.*Never/,
    );
    await user.click(screen.getByRole("button", { name: "New token" }));
    await user.click(await screen.findByRole("button", { name: "Create" }));
    expect(await screen.findByText("Type a name.")).toBeDefined();
    await user.type(screen.getByLabelText("Name"), "Script");
    await user.click(screen.getByRole("button", { name: "Create" }));
    expect(await screen.findByText("dgw_new")).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Close" }));
    await waitFor(() => expect(screen.queryByText("dgw_new")).toBeNull());
    await user.click(await screen.findByRole("button", { name: "Revoke Night shift" }));
    await user.click(await screen.findByRole("button", { name: "Revoke" }));
    await waitFor(() => expect(screen.queryByRole("listitem", { name: "Night shift" })).toBeNull());
    expect(asked).toContain(`DELETE /tokens/${NIGHT.id}`);
  });

  it("says to others that tokens are for admins", async () => {
    const asked = answering([NIGHT]);
    session.set(as("supervisor"));
    renderPage(fakeGateway(), {}, "/ui/tokens");
    await screen.findByRole("heading", { name: "Tokens" });
    expect(screen.getAllByText("Needs the role admin; you are supervisor.").length).toBeGreaterThan(0);
    expect(asked).not.toContain("GET /tokens");
  });
});
