import { notifications } from "@mantine/notifications";
import { act, screen, within } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import "../../../src/access/AccountMenu";
import { changePassword, logIn, logOut } from "../../../src/api/access";
import { goalsExportUrl } from "../../../src/api/goals";
import { createHttp } from "../../../src/api/http";
import { ANYBODY, Session, type SessionState, session } from "../../../src/api/session";
import { apiAddress, pageSite, siteKey, sitePrefix } from "../../../src/api/site";
import { streamUrl } from "../../../src/stream/stream";
import { fakeGateway, renderPage } from "../../page";

const at = (path: string) => window.history.replaceState(null, "", path);
const origin = window.location.origin;
const known = (change: Partial<NonNullable<SessionState["principal"]>> = {}): SessionState => ({
  ...ANYBODY,
  required: true,
  principal: { name: "ada", kind: "user", role: "admin", robots: [], actions: [], topics: [], ...change },
});

afterEach(() => {
  at("/");
  session.set(ANYBODY);
});

describe("the page of a site", () => {
  it.each([
    ["/", null],
    ["/ui/goals", null],
    ["/sites", null],
    ["/sites/berlin", null],
    ["/sites/berlin/", "berlin"],
    ["/sites/hall_2/ui/robot", "hall_2"],
    ["/sites/Berlin/", null],
    ["/ui/sites/berlin/", null],
  ])("%s is that of %s", (path, site) => {
    at(path);
    expect(pageSite()).toBe(site);
    expect(sitePrefix()).toBe(site === null ? "" : `/sites/${site}`);
  });

  it("has its requests, streams, files and command lines at the site", () => {
    at("/sites/berlin/ui/goals");
    expect(apiAddress()).toBe(`${origin}/sites/berlin`);
    expect(streamUrl({ protocol: "https:", host: "hub" }, { robot: "/r1" })).toBe(
      "wss://hub/sites/berlin/ws/feedback?robot=%2Fr1",
    );
    expect(goalsExportUrl({}, "csv")).toBe("/sites/berlin/goals/export?format=csv");
  });

  it("keeps what names robots apart from other sites", () => {
    expect(siteKey("views")).toBe("views");
    at("/sites/berlin/");
    expect(siteKey("views")).toBe("views berlin");
  });

  it("logs in and out at the hub", async () => {
    at("/sites/berlin/");
    const fetch = vi.fn(async (_request: Request) => Response.json(known()));
    vi.stubGlobal("fetch", fetch);
    const http = createHttp(apiAddress());
    await logIn(http, { token: "dgw_x" });
    await logOut(http);
    await changePassword(http, { old: "a", new: "b" });
    expect(fetch.mock.calls.map(([{ url }]) => url)).toEqual(
      ["/session", "/session", "/session/password"].map((path) => origin + path),
    );
    vi.unstubAllGlobals();
  });
});

describe("who uses the page of a site", () => {
  const answers = new Map<string, () => Response>();
  beforeEach(() => {
    at("/sites/berlin/");
    answers.clear();
    answers.set("/session", () => Response.json({ ...known(), hub: true }));
    vi.stubGlobal(
      "fetch",
      async (path: string) => answers.get(path)?.() ?? Promise.reject(new TypeError("Failed to fetch")),
    );
  });
  afterEach(() => vi.unstubAllGlobals());

  it("is who is logged in at the hub, and may do what the site lets them", async () => {
    const here = known({ name: "hub:ada", kind: "token", role: "operator", robots: ["/robot1"] });
    answers.set("/sites/berlin/session", () => Response.json(here));
    const asked = new Session();
    await asked.ask();
    expect(asked.state).toMatchObject(known({ role: "operator", robots: ["/robot1"] }));
  });

  it("is known where the site does not answer, and why it does not is, too", async () => {
    const trouble = { status: 503, code: "site_unreachable", detail: "berlin is not connected." };
    answers.set("/sites/berlin/session", () => Response.json(trouble, { status: 503 }));
    const asked = new Session();
    await asked.ask();
    expect(asked.state).toMatchObject({ ...known(), trouble });
    answers.delete("/sites/berlin/session");
    await asked.ask();
    expect(asked.state).toMatchObject({ ...known(), trouble: null });
  });

  it("is asked again after a login: the hub's answer does not say what the site lets them do", async () => {
    answers.set("/sites/berlin/session", () => Response.json(known({ role: "viewer" })));
    const asked = new Session();
    asked.set(known());
    expect(asked.state).toBe(ANYBODY);
    await asked.ask();
    expect(asked.state.principal?.role).toBe("viewer");
  });
});

describe("the frame of a site's page", () => {
  it("says the site, and leads to all of them", () => {
    at("/sites/berlin/");
    renderPage(fakeGateway());
    const header = within(screen.getByRole("banner"));
    expect(header.getByRole<HTMLAnchorElement>("link", { name: "All sites" }).pathname).toBe("/");
    expect(header.getByRole("link", { name: "berlin" })).toBeDefined();
    expect(document.title).toMatch(/ · berlin · dock-gateway$/);
  });

  it("leaves people and tokens to the hub", async () => {
    at("/sites/berlin/");
    vi.stubGlobal("fetch", async () => Response.json(known()));
    await session.ask();
    vi.unstubAllGlobals();
    const { user } = renderPage(fakeGateway());
    await user.click(await screen.findByRole("button", { name: "Logged in as ada, admin" }));
    const items = (await screen.findAllByRole("menuitem")).map(({ textContent }) => textContent);
    expect(items).toEqual(["Audit", "Change password …", "Log out", "Log out everywhere"]);
  });

  it("stops the site through the hub, which repeats it", async () => {
    at("/sites/berlin/");
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    const stopped = { stopped: true, robots: [], warning: null, code: null, detail: null, repeated: false };
    const fetch = vi.fn(async (_request: Request) =>
      Response.json({ sites: { berlin: stopped }, warning: null }),
    );
    vi.stubGlobal("fetch", fetch);
    await user.click(screen.getByRole("button", { name: "Stop" }));
    expect(await screen.findByText(/^Stopped: berlin/)).toBeDefined();
    const sent = fetch.mock.calls.map(([request]) => request).filter(({ method }) => method !== "GET");
    expect(sent.map(({ url }) => url)).toEqual([`${origin}/stop?robot=%2Fberlin`]);
    expect(gateway.stop).not.toHaveBeenCalled();
    vi.unstubAllGlobals();
    act(() => notifications.clean());
  });

  it("says why the site is not reached", async () => {
    at("/sites/berlin/");
    const { store } = renderPage(fakeGateway());
    act(() => store.onConnection({ kind: "closed" }));
    const trouble = { status: 503, code: "site_unreachable", detail: "the site berlin is not connected" };
    vi.stubGlobal("fetch", async (path: string) =>
      path === "/session" ? Response.json(known()) : Response.json(trouble, { status: 503 }),
    );
    await act(() => session.ask());
    vi.unstubAllGlobals();
    expect(screen.getByTestId("connection").textContent).toBe("site away");
    const alert = screen.getByRole("alert", { name: "berlin cannot be reached" });
    expect(alert.textContent).toContain("The site berlin is not connected.");
  });
});
