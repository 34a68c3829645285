import { QueryObserver } from "@tanstack/react-query";
import { act, screen, waitFor } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import "../src/access/AccountMenu";
import "../src/access/LoginForm";
import "../src/access/LoginPage";
import "../src/access/TokensPage";
import "../src/access/UsersPage";
import { ownName, setOwnName } from "../src/access/who";
import type { Token, User } from "../src/api/access";
import { createQueryClient, pauseWhileUnseen } from "../src/api/queryClient";
import { ANYBODY, type Role, Session, type SessionState, session, whyForbidden } from "../src/api/session";
import { whyNot } from "../src/operations/operation";
import { robot } from "./events";
import { descriptionOf, fakeGateway, isDisabled, renderPage } from "./page";

const OUT: SessionState = {
  required: true,
  open_to: null,
  principal: null,
  provider: null,
  share: [],
};
const as = (role: Role, name = "Ada", kind: "token" | "user" | "person" = "token"): SessionState => ({
  required: true,
  open_to: null,
  principal: { name, kind, role, robots: [], actions: [], topics: [] },
  provider: null,
  share: [],
});

const BOB: User = {
  name: "bob",
  etag: '"b1"',
  role: "operator",
  robots: ["/hall_a/*"],
  actions: [],
  topics: [],
  disabled: false,
  created_by: "root",
  created_at: "2026-11-23T09:00:00Z",
  logged_in_at: null,
  sessions: 2,
};

const NIGHT: Token = {
  id: "0123456789abcdef",
  etag: '"n1"',
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

/**
 * A gateway with one valid token, `dgw_right`, a user `ada` with the password `right`, and lists of tokens and users; it
 * remembers what it is asked, and the bodies.
 */
function answering(tokens: Token[] = [], users: User[] = []) {
  const asked: string[] = [];
  const refuse = (status: number, code: string) =>
    Response.json({ code, title: "No", detail: "no" }, { status });
  vi.stubGlobal("fetch", async (request: Request | string) => {
    if (typeof request === "string") return Response.json(session.state);
    const { pathname } = new URL(request.url);
    asked.push(`${request.method} ${pathname}`);
    if (pathname === "/session" && request.method === "POST") {
      const body = (await request.json()) as { token?: string; user?: string; password?: string };
      if (body.token === "dgw_right") return Response.json(as("operator"));
      if (body.token !== undefined) return refuse(401, "invalid_token");
      if (body.password === "slow") return refuse(429, "too_many_logins");
      if (body.password !== "right") return refuse(401, "invalid_login");
      return Response.json(as("operator", body.user, "user"));
    }
    if (pathname === "/session/password") {
      const { old } = (await request.json()) as { old: string };
      return old === "right" ? new Response(null, { status: 204 }) : refuse(403, "wrong_password");
    }
    if (pathname === "/users") return Response.json({ users });
    if (request.method === "PUT" && pathname.startsWith("/users/")) {
      const name = pathname.slice("/users/".length);
      const body = (await request.json()) as Partial<User>;
      asked.push(JSON.stringify(body));
      users = [...users.filter((user) => user.name !== name), { ...BOB, ...body, name }];
      return Response.json(users.at(-1));
    }
    if (request.method === "DELETE" && pathname.startsWith("/users/")) {
      if (pathname.endsWith("/sessions")) users = users.map((user) => ({ ...user, sessions: 0 }));
      else users = users.filter(({ name }) => pathname !== `/users/${name}`);
      return new Response(null, { status: 204 });
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
  it("say what role something needs", () => {
    expect(whyForbidden("DELETE /stop")).toBeNull();
    session.set(as("operator"));
    expect(whyForbidden("POST /dock")).toBeNull();
    expect(whyForbidden("DELETE /stop")).toBe("Needs the role supervisor; you are operator.");
    const limited = as("supervisor");
    if (limited.principal !== null) limited.principal.robots = ["/robot1"];
    session.set(limited);
    expect(whyForbidden("DELETE /stop")).toBeNull();
    expect(whyForbidden("PUT /label")).toBe("This is about every robot, and your access is limited to some.");
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

  it("takes no answer about a login that has changed since", async () => {
    const own = new Session();
    const answers: ((answer: Response) => void)[] = [];
    const slow = () => new Promise<Response>((resolve) => answers.push(resolve));
    vi.stubGlobal("fetch", slow);
    const asked = own.ask(); // the stream ended: the gateway has changed the login, but its answer is on the way
    vi.stubGlobal("fetch", async () => Response.json(as("operator")));
    await own.askAgain();
    answers.pop()?.(Response.json(OUT));
    await asked;
    expect(own.loggedOut).toBe(false);
    vi.stubGlobal("fetch", slow);
    const before = own.ask();
    own.set(as("viewer"));
    answers.pop()?.(Response.json(OUT));
    await before;
    expect(own.state).toEqual(as("viewer"));
  });

  it("ends what is asked for again and again, until somebody logs in", async () => {
    vi.useFakeTimers();
    pauseWhileUnseen();
    const ask = vi.fn(async () => "notes");
    const client = createQueryClient();
    const watched = new QueryObserver(client, { queryKey: ["notes"], queryFn: ask, refetchInterval: 1000 });
    const stop = watched.subscribe(() => {});
    await vi.advanceTimersByTimeAsync(3500);
    expect(ask).toHaveBeenCalledTimes(4);
    session.set(OUT);
    await vi.advanceTimersByTimeAsync(10_000);
    expect(ask).toHaveBeenCalledTimes(4);
    session.set(as("viewer"));
    await vi.advanceTimersByTimeAsync(2500);
    expect(ask.mock.calls.length).toBeGreaterThan(5);
    stop();
    vi.useRealTimers();
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

  it("says that no login is needed on this machine, and what that means", async () => {
    answering();
    session.set({ ...ANYBODY, open_to: "machine" });
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Open: no login on this machine" }));
    expect(screen.queryByRole("menuitem", { name: "Log out" })).toBeNull();
    await user.click(await screen.findByRole("menuitem", { name: "What this means" }));
    expect(await screen.findByText(/Every program and every user of the gateway's machine/)).toBeDefined();
    expect(screen.queryByText(/Everyone who reaches this gateway/)).toBeNull();
  });

  it("warns on every page of a gateway that is open to a network, until that is closed", async () => {
    answering();
    session.set({ ...ANYBODY, open_to: "network" });
    const { user } = renderPage(fakeGateway());
    expect(await screen.findByText(/Everyone who reaches this gateway/)).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Close the warning" }));
    expect(screen.queryByText(/Everyone who reaches this gateway/)).toBeNull();
    expect(await screen.findByRole("button", { name: "Open to the network: no login" })).toBeDefined();
  });

  it("asks for a name and a password first, says what is wrong, and then shows the page", async () => {
    answering();
    session.set(OUT);
    const { user } = renderPage(fakeGateway());
    const name = await screen.findByLabelText("Name");
    expect(document.activeElement).toBe(name);
    expect(screen.queryByRole("button", { name: "Stop" })).toBeNull();
    await user.keyboard("{Enter}");
    expect(await screen.findByText("Enter your name.")).toBeDefined();
    await user.type(name, "ada{Enter}");
    expect(await screen.findByText("Enter your password.")).toBeDefined();
    const password = screen.getByLabelText("Password");
    expect(document.activeElement).toBe(password);
    await user.type(password, "wrong{Enter}");
    expect(await screen.findByText(/The name or the password is wrong/)).toBeDefined();
    await user.clear(password);
    await user.type(password, "slow{Enter}");
    expect(await screen.findByText(/too many logins have failed/)).toBeDefined();
    await user.clear(password);
    await user.type(password, "right{Enter}");
    expect(await screen.findByRole("button", { name: "Logged in as ada, operator" })).toBeDefined();
  });

  it("takes a token, too, and says what is wrong with it", async () => {
    answering();
    session.set(OUT);
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Log in with a token" }));
    const field = await screen.findByLabelText("Token");
    expect(document.activeElement).toBe(field);
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
    await user.type(await screen.findByLabelText("Name"), "ada");
    await user.type(screen.getByLabelText("Password"), "right{Enter}");
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

  it("changes the own password", async () => {
    const asked = answering();
    session.set(as("viewer", "ada", "user"));
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Logged in as ada, viewer" }));
    expect(screen.queryByRole("menuitem", { name: "Users" })).toBeNull();
    expect(await screen.findByRole("menuitem", { name: "Log out everywhere" })).toBeDefined();
    await user.click(screen.getByRole("menuitem", { name: "Change password …" }));
    await user.click(await screen.findByRole("button", { name: "Change" }));
    expect(await screen.findByText("Enter your old password.")).toBeDefined();
    expect(screen.getByText("Type at least 12 characters.")).toBeDefined();
    expect(asked).not.toContain("PUT /session/password");
    await user.type(screen.getByLabelText("Old password"), "wrong");
    await user.type(screen.getByLabelText("New password"), "correct horse battery");
    await user.click(screen.getByRole("button", { name: "Change" }));
    expect(await screen.findByText("The old password is wrong.")).toBeDefined();
    await user.clear(screen.getByLabelText("Old password"));
    await user.type(screen.getByLabelText("Old password"), "right");
    await user.click(screen.getByRole("button", { name: "Change" }));
    await waitFor(() => expect(screen.queryByLabelText("Old password")).toBeNull());
  });

  it("has no password for who logged in with a token", async () => {
    answering();
    session.set(as("admin"));
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Logged in as Ada, admin" }));
    expect(await screen.findByRole("menuitem", { name: "Users" })).toBeDefined();
    expect(screen.queryByRole("menuitem", { name: "Change password …" })).toBeNull();
    expect(screen.queryByRole("menuitem", { name: "Log out everywhere" })).toBeNull();
  });

  it("has users for admins: adds, changes, logs out and removes them", async () => {
    const asked = answering([], [BOB]);
    session.set(as("admin"));
    const { user } = renderPage(fakeGateway(), {}, "/ui/users");
    expect((await screen.findByRole("listitem", { name: "bob" })).textContent).toMatch(
      /operator.*Added.*by root.*Only for.*hall_a.*Last login.*Never.*Logged in.*In 2 browsers/,
    );
    await user.click(screen.getByRole("button", { name: "New user" }));
    await user.click(await screen.findByRole("button", { name: "Add" }));
    expect(await screen.findByText("Type a name.")).toBeDefined();
    expect(screen.getByText("Type at least 12 characters.")).toBeDefined();
    await user.type(screen.getByLabelText("Name"), "bob");
    expect(await screen.findByText("There is a user of this name.")).toBeDefined();
    await user.type(screen.getByLabelText("Name"), "by");
    await user.type(screen.getByLabelText("Password"), "correct horse battery");
    await user.click(screen.getByRole("button", { name: "Add" }));
    expect(await screen.findByRole("listitem", { name: "bobby" })).toBeDefined();
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(asked.at(-2)).toMatch(/"role":"viewer".*"password":"correct horse battery"/);

    await user.click(screen.getByRole("button", { name: "Edit bob" }));
    await user.click(await screen.findByRole("switch", { name: /^Disabled/ }));
    await user.click(screen.getByRole("button", { name: "Save" }));
    await waitFor(() =>
      expect(screen.getByRole("listitem", { name: "bob" }).textContent).toMatch(/disabled/),
    );
    const changed = asked.findLast((each) => each.startsWith("{"));
    expect(changed).toMatch(/"robots":\["\/hall_a\/\*"\].*"disabled":true/);
    expect(changed).not.toMatch(/password/);

    await user.click(screen.getByRole("button", { name: "Log out bob" }));
    await waitFor(() => expect(isDisabled("Log out bob")).toBe(true));
    await user.click(screen.getByRole("button", { name: "Remove bob" }));
    await user.click(await screen.findByRole("button", { name: "Remove" }));
    await waitFor(() => expect(screen.queryByRole("listitem", { name: "bob" })).toBeNull());
    expect(asked).toContain("DELETE /users/bob");
  });

  it("lets a person of the identity provider log out everywhere, and has no password for them", async () => {
    answering();
    session.set(as("operator", "oidc:grace", "person"));
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Logged in as oidc:grace, operator" }));
    expect(await screen.findByRole("menuitem", { name: "Log out everywhere" })).toBeTruthy();
    expect(screen.queryByRole("menuitem", { name: "Change password …" })).toBeNull();
  });

  it("says to others that users are for admins", async () => {
    const asked = answering([], [BOB]);
    session.set(as("supervisor"));
    renderPage(fakeGateway(), {}, "/ui/users");
    await screen.findByRole("heading", { name: "Users" });
    expect(screen.getAllByText("Needs the role admin; you are supervisor.").length).toBeGreaterThan(0);
    expect(asked).not.toContain("GET /users");
  });
});
