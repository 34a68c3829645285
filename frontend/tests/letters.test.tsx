import { fireEvent, screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Letters, SECOND_WITHIN_MS } from "../src/layout/ShortcutsButton";
import { robot } from "./events";
import { fakeGateway, renderPage } from "./page";

beforeEach(() => {
  localStorage.clear();
  vi.stubGlobal("fetch", () => new Promise(() => {}));
});

const PAGES = [
  { letter: "o", to: "/" },
  { letter: "g", to: "/ui/goals" },
];

describe("letters", () => {
  function press(letters: Letters, key: string, at: number, change: KeyboardEventInit = {}) {
    const event = new KeyboardEvent("keydown", { key, ...change });
    Object.defineProperty(event, "timeStamp", { value: at });
    fireEvent(document.body, event);
    return letters.press(event);
  }

  it("go to a page where they follow a g, soon", () => {
    const letters = new Letters(PAGES);
    expect(press(letters, "g", 0)).toBeNull();
    expect(press(letters, "o", SECOND_WITHIN_MS)).toEqual({ kind: "page", to: "/" });
    expect(press(letters, "o", SECOND_WITHIN_MS + 1)).toBeNull();
    expect([press(letters, "g", 5000), press(letters, "g", 5100)]).toEqual([
      null,
      { kind: "page", to: "/ui/goals" },
    ]);
    expect(press(letters, "a", 5200)).toBeNull();
    press(letters, "g", 9000);
    expect(press(letters, "a", 9001 + SECOND_WITHIN_MS)).toBeNull();
  });

  it("mean something else with a key that is held besides", () => {
    const letters = new Letters(PAGES);
    press(letters, "g", 0);
    expect(press(letters, "r", 10, { ctrlKey: true })).toBeNull();
    expect(press(letters, "r", 20)).toBeNull();
    press(letters, "Shift", 30, { shiftKey: true });
    expect(press(letters, "?", 40, { shiftKey: true })).toEqual({ kind: "list" });
  });
});

describe("the keyboard", () => {
  const robots = [robot("/robot1"), robot("/robot2")];

  it("goes to the pages", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    await user.keyboard("ga");
    expect(await screen.findByRole("heading", { level: 1, name: "Actions" })).toBeDefined();
    await user.keyboard("go");
    expect(await screen.findByRole("heading", { level: 1, name: "Overview" })).toBeDefined();
  });

  it("shows what it does when asked by ?, and goes nowhere from there", async () => {
    const { user } = renderPage(fakeGateway());
    await user.keyboard("?");
    const dialog = await screen.findByRole("dialog", { name: "Keyboard and name" });
    await waitFor(() => expect(dialog.textContent).toMatch(/Go to Actions/));
    await user.keyboard("gr");
    expect(screen.queryByRole("heading", { level: 1, name: "Graph" })).toBeNull();
  });

  it("leaves letters to text fields, and to those who switched them off", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    await user.keyboard("?");
    await user.type(await within(await screen.findByRole("dialog")).findByLabelText("Your name"), "gr?");
    await user.click(screen.getByLabelText(/^Single-key shortcuts/));
    await user.keyboard("{Escape}");
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    await user.keyboard("?gr");
    expect(screen.queryByRole("dialog")).toBeNull();
    expect(screen.getByRole("heading", { level: 1, name: "Overview" })).toBeDefined();
  });
});
