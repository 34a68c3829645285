import { screen, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import "../../../src/access/LoginForm";
import "../../../src/access/LoginPage";
import "../../../src/access/UsersPage";
import { ANYBODY, type SessionState, session } from "../../../src/api/session";
import "../../../src/extensions/single_sign_on/PeopleList";
import { takeFailure } from "../../../src/extensions/single_sign_on/ProviderLogin";
import type { Person } from "../../../src/extensions/single_sign_on/requests";
import { fakeGateway, renderPage } from "../../page";

const ADMIN: SessionState = {
  required: true,
  open_to: null,
  principal: { name: "root", kind: "user", role: "admin", robots: [], actions: [], topics: [] },
  provider: null,
  share: [],
};

/** A gateway where people are logged in with the identity provider; it remembers what it is asked. */
function answering(people: Person[] = []) {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request | string) => {
    if (typeof request === "string") return Response.json(session.state);
    const { pathname } = new URL(request.url);
    asked.push(`${request.method} ${pathname}`);
    if (pathname === "/users") return Response.json({ users: [] });
    if (pathname === "/people") return Response.json({ people });
    if (!pathname.startsWith("/people/")) return Response.json({}, { status: 404 });
    people = people.filter(({ name }) => pathname !== `/people/${encodeURIComponent(name)}/sessions`);
    return new Response(null, { status: 204 });
  });
  return asked;
}

beforeEach(() => session.set(ANYBODY));

describe("single sign-on", () => {
  it("leads to the identity provider, says why a login with it has failed, and keeps the address clean", async () => {
    answering();
    window.history.replaceState(null, "", "/ui/goals?status=failed&login_error=role_required");
    takeFailure(window);
    expect(window.location.search).toBe("?status=failed");
    session.set({
      ...ADMIN,
      principal: null,
      provider: { name: "Site login", logout_url: "https://login.example/logout" },
    });
    renderPage(fakeGateway());
    const link = await screen.findByRole("link", { name: "Log in with Site login" });
    expect(link.getAttribute("href")).toBe("/session/oidc?page=%2Fui%2Fgoals%3Fstatus%3Dfailed");
    expect(screen.getByText(/you have no role here/)).toBeTruthy();
    expect(screen.getByRole("link", { name: "Log out at Site login" })).toBeTruthy();
    expect(screen.getByLabelText("Name")).toBeTruthy();
    window.history.replaceState(null, "", "/");
    takeFailure(window);
  });

  it("shows admins who is logged in with the identity provider, and logs them out", async () => {
    const person: Person = {
      name: "oidc:grace/1",
      role: "operator",
      robots: ["/hall_a/*"],
      actions: [],
      topics: [],
      subject: "4711",
      sessions: 1,
      logged_in_at: "2026-11-24T09:00:00Z",
      expires_at: "2026-11-24T21:00:00Z",
    };
    const asked = answering([person]);
    session.set({ ...ADMIN, provider: { name: "Site login", logout_url: null } });
    const { user } = renderPage(fakeGateway(), {}, "/ui/users");
    const list = await screen.findByRole("list", { name: "Logged in with Site login" });
    expect(await within(list).findByText("4711")).toBeTruthy();
    await user.click(within(list).getByRole("button", { name: "Log out oidc:grace/1" }));
    await screen.findByText("oidc:grace/1 is logged out everywhere.");
    expect(asked).toContain("DELETE /people/oidc%3Agrace%2F1/sessions");
    expect(await screen.findByText("No one is logged in.")).toBeTruthy();
  });
});
