import { screen, waitFor, within } from "@testing-library/react";
import { beforeEach, expect, it, vi } from "vitest";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../src/help/HelpPage";
import "../src/notifications/NotificationsPage";
import { fakeGateway, renderPage } from "./page";

const open = (path: string) => renderPage(fakeGateway(), {}, path).user;

const scrolled = vi.fn();
beforeEach(() => {
  scrolled.mockClear();
  Element.prototype.scrollIntoView = scrolled;
});

it("is where the question mark of a card leads", async () => {
  const user = open("/ui/notifications");
  await user.click(await screen.findByRole("link", { name: "Help: Notifications" }));
  const heading = await screen.findByRole("heading", { name: "Notifications in this browser" });
  await waitFor(() => expect(document.activeElement).toBe(heading));
  expect(scrolled).toHaveBeenCalledOnce();
});

it("leads from page to page within the dashboard", async () => {
  const user = open("/ui/help");
  await user.click(await screen.findByRole("link", { name: "Stop" }));
  expect(await screen.findByRole("heading", { level: 1, name: "Stop" })).toBeDefined();
  await user.click(screen.getByRole("link", { name: "All pages of the help" }));
  expect(await screen.findByRole("heading", { level: 1, name: "All pages" })).toBeDefined();
});

it("is searched as a whole", async () => {
  const user = open("/ui/help");
  await user.type(await screen.findByRole("searchbox", { name: "Search the help" }), "zero velocity");
  expect(await screen.findByRole("heading", { name: "Found in the help" })).toBeDefined();
  const main = within(screen.getByRole("main"));
  await user.click(await main.findByRole("link", { name: "Stop: Zero velocity" }));
  const heading = await screen.findByRole("heading", { name: "Zero velocity" });
  await waitFor(() => expect(document.activeElement).toBe(heading));
});

it("says that a page is not there", async () => {
  open("/ui/help/nothing");
  expect(await screen.findByRole("heading", { name: "No such page of the help" })).toBeDefined();
});
