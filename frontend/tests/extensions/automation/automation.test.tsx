import { screen, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import type { Decision, Rule, RuleBody } from "../../../src/extensions/automation/requests";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/automation/AutomationPage";
import { bodyOf, draftOf, errorsOf, withMode } from "../../../src/extensions/automation/draft";
import { conditionWords, reasonWords } from "../../../src/extensions/automation/words";
import { Naming } from "../../../src/fleet/names";
import { robotsWords } from "../../../src/fleet/robotChoice";
import { newId } from "../../../src/ui/text";
import { fakeGateway, renderPage } from "../../page";

const LOW: Rule = {
  id: "low-battery",
  etag: '"1"',
  name: "Low battery",
  mode: "off",
  robots: { all: true, names: [], groups: [] },
  battery: { below: 0.2, idle_s: 60 },
  schedule: null,
  changed_by: "Ada",
  changed_at: "2026-11-21T10:00:00Z",
  applies_to: [
    { robot: "/robot1", waits_for: "off" },
    { robot: "/robot2", waits_for: "off" },
  ],
};
const NIGHT: Rule = {
  ...LOW,
  id: "night",
  name: "Night",
  robots: { all: false, names: ["/robot1"], groups: ["hall 1"] },
  battery: null,
  schedule: { times: ["22:00"], weekdays: ["mon", "tue", "wed", "thu", "fri"], time_zone: "Europe/Berlin" },
};
const SENT: Decision = {
  id: "a",
  rule_id: "low-battery",
  rule_name: "Low battery",
  robot: "/robot1",
  decided_at: "2026-11-21T10:01:00Z",
  outcome: "sent",
  battery: 0.18,
  idle_since_at: "2026-11-21T10:00:00Z",
  scheduled_at: null,
  goal_id: "3f0c",
  code: null,
  detail: null,
};

/** A gateway with these rules and decisions; it remembers what it is asked to store. */
function answering(rules: Rule[], decisions: Decision[] = []) {
  const stored: { id: string; body: RuleBody | null }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const { pathname } = new URL(request.url);
    const id = pathname.split("/")[3] ?? "";
    if (pathname === "/automation/decisions") return Response.json({ decisions });
    if (pathname === "/automation/rules") return Response.json({ rules });
    if (pathname === "/automation/holds" && request.method === "DELETE") {
      const goesOn = new URL(request.url).searchParams.get("robot");
      const waiting = (each: Rule["applies_to"][number]) =>
        each.robot === goesOn ? { ...each, waits_for: "not_idle" as const } : each;
      rules = rules.map((rule) => ({ ...rule, applies_to: rule.applies_to.map(waiting) }));
      return new Response(null, { status: 204 });
    }
    if (!pathname.startsWith("/automation/rules/")) return Response.json({}, { status: 404 });
    const body = request.method === "PUT" ? ((await request.json()) as RuleBody) : null;
    stored.push({ id, body });
    const before = rules.find((rule) => rule.id === id);
    const match = request.headers.get("If-Match");
    if (match !== null && match !== before?.etag) {
      const problem = { code: "changed_meanwhile", title: "Changed meanwhile", detail: "no" };
      return Response.json(problem, { status: 412 });
    }
    const others = rules.filter((rule) => rule.id !== id);
    if (body === null) {
      rules = others;
      return new Response(null, { status: 204 });
    }
    const known = before ?? { ...LOW, id };
    const saved = { ...known, etag: `"v${stored.length}"`, name: body.name, mode: body.mode ?? "off" };
    rules = [...others, saved];
    return Response.json(saved);
  });
  return stored;
}

const open = () => renderPage(fakeGateway(), {}, "/ui/automation");
const spaces = (text: string) => text.replaceAll("\u00a0", " ");

describe("the words", () => {
  it("say when a rule docks which robots", () => {
    expect(spaces(conditionWords(LOW))).toBe("Battery below 20 % and idle for 1 min 00 s");
    expect(conditionWords(NIGHT)).toBe("At 22:00, Mon–Fri (Europe/Berlin)");
    const naming = new Naming([{ name: "/robot1", display_name: "Left forklift", groups: [] }]);
    expect(robotsWords(LOW.robots, naming)).toBe("All robots");
    expect(robotsWords(NIGHT.robots, naming)).toBe("Left forklift, robots in hall 1");
  });

  it("say why it was decided so", () => {
    expect(spaces(reasonWords(SENT))).toBe("Battery 18 %, idle for 1 min 00 s");
    const held: Decision = { ...SENT, outcome: "held", code: "stop_latched", detail: "stopped by Bob" };
    expect(spaces(reasonWords(held))).toContain(". Stopped by Bob");
    const skipped: Decision = {
      ...SENT,
      outcome: "skipped",
      code: "goal_running",
      scheduled_at: "2026-11-21T10:00:00Z",
    };
    expect(reasonWords(skipped)).toMatch(/^Due at .*\. A goal is running$/);
    const refused: Decision = { ...SENT, outcome: "refused", code: "dock_busy", detail: "a goal is running" };
    expect(reasonWords(refused)).toContain(". a goal is running");
    expect(reasonWords({ ...SENT, outcome: "gave_up" })).toContain("Three attempts");
  });
});

describe("a draft", () => {
  it("is stored as it was read", () => {
    for (const rule of [LOW, NIGHT]) {
      const body = bodyOf(draftOf(rule), rule.mode, "Bob");
      expect(body).toMatchObject({ name: rule.name, mode: "off", by: "Bob" });
      expect(body.battery ?? null).toEqual(rule.battery);
      expect(body.schedule ?? null).toEqual(rule.schedule);
    }
    expect(bodyOf(draftOf(NIGHT), "on", null).robots).toEqual({ names: ["/robot1"], groups: ["hall 1"] });
    expect(withMode(LOW, "on", null)).toMatchObject({ mode: "on", battery: LOW.battery, schedule: null });
  });

  it("says what is wrong with it", () => {
    expect(errorsOf(draftOf(LOW))).toEqual({});
    const empty = { ...draftOf(LOW), name: " ", all: false, names: [], below: "", idleSeconds: 5 };
    expect(Object.keys(errorsOf(empty))).toEqual(["name", "names", "below", "idleSeconds"]);
    const late = { ...draftOf(NIGHT), times: ["9:00", "24:00"], weekdays: [] };
    expect(Object.keys(errorsOf(late))).toEqual(["times", "weekdays"]);
    expect(bodyOf({ ...late, times: ["9:00"] }, "off", null).schedule?.times).toEqual(["09:00"]);
  });

  it("gets an id that no rule has", () => {
    expect(newId("Akku schwach (Halle ä)", [], "rule")).toBe("akku-schwach-halle-a");
    expect(newId("Night", ["night", "night-2"], "rule")).toBe("night-3");
    expect(newId("夜", [], "rule")).toBe("rule");
    expect(newId("x".repeat(60), [], "rule").length).toBeLessThanOrEqual(40);
  });
});

describe("the page", () => {
  it("switches a rule on after asking once, with the robots' names", async () => {
    const stored = answering([LOW], [SENT]);
    const { user } = open();
    const mode = await screen.findByRole("radiogroup", { name: "Mode of Low battery" });
    await user.click(within(mode).getByText("On"));
    const dialog = await screen.findByRole("dialog", { name: "Switch on Low battery?" });
    expect(within(dialog).getByText("/robot1")).toBeDefined();
    expect(within(dialog).getByText("/robot2")).toBeDefined();
    await user.click(within(dialog).getByRole("button", { name: "Cancel" }));
    expect(stored).toEqual([]);
    await user.click(within(mode).getByText("Dry run"));
    await user.click(within(mode).getByText("On"));
    const again = await screen.findByRole("dialog", { name: "Switch on Low battery?" });
    await user.type(within(again).getByLabelText("Your name"), "Bob");
    await user.click(within(again).getByRole("button", { name: "Switch on" }));
    await vi.waitFor(() =>
      expect(stored.map(({ body }) => [body?.mode, body?.by])).toEqual([
        ["dry_run", null],
        ["on", "Bob"],
      ]),
    );
  });

  it("lets a rule go on with a robot that was stopped", async () => {
    const applies_to = ["/robot1", "/robot2"].map((robot) => ({ robot, waits_for: "stopped" as const }));
    answering([{ ...LOW, mode: "on", applies_to }]);
    const { user } = open();
    await user.click(await screen.findByRole("button", { name: "Continue automatic docking of /robot1" }));
    expect(await screen.findByText("Not idle long enough")).toBeDefined();
    expect(screen.queryByRole("button", { name: "Continue automatic docking of /robot1" })).toBeNull();
    expect(screen.getByRole("button", { name: "Continue automatic docking of /robot2" })).toBeDefined();
  });

  it("adds a rule, which is off, and says what is missing first", async () => {
    const stored = answering([]);
    const { user } = open();
    await screen.findByText("No rules");
    await user.click(screen.getByRole("button", { name: "New rule" }));
    const dialog = await screen.findByRole("dialog", { name: "New rule" });
    await user.click(within(dialog).getByRole("button", { name: "Save" }));
    expect(within(dialog).getByText("Type a name.")).toBeDefined();
    await user.type(within(dialog).getByLabelText("Name"), "Low battery");
    await user.click(within(dialog).getByRole("button", { name: "Save" }));
    await screen.findByRole("radiogroup", { name: "Mode of Low battery" });
    expect(stored).toMatchObject([
      {
        id: "low-battery",
        body: { mode: "off", robots: { all: true }, battery: { below: 0.2, idle_s: 60 } },
      },
    ]);
  });

  it("starts from an example", async () => {
    const stored = answering([]);
    const { user } = open();
    await user.click(await screen.findByRole("button", { name: "Example: Dock every night at 22:00" }));
    const dialog = await screen.findByRole("dialog", { name: "New rule" });
    await user.click(within(dialog).getByRole("button", { name: "Save" }));
    await screen.findByRole("radiogroup", { name: "Mode of Night" });
    expect(stored[0]?.body).toMatchObject({ mode: "off", schedule: { times: ["22:00"] } });
  });

  it.each([
    ["Show the new version", "Night", "off"],
    ["Replace it with mine", "Mine", "off"],
  ])("does not lose what someone else has changed meanwhile: %s", async (button, name, mode) => {
    const stored = answering([{ ...LOW, mode: "on" }]);
    const { user } = open();
    await user.click(await screen.findByRole("button", { name: "Edit Low battery" }));
    const field = await screen.findByRole("textbox", { name: "Name" });
    await user.clear(field);
    await user.type(field, "Mine");
    const body = JSON.stringify({ name: "Night", mode: "off" });
    await fetch(new Request("http://gateway:8000/automation/rules/low-battery", { method: "PUT", body }));
    await user.click(screen.getByRole("button", { name: "Save" }));
    expect(await screen.findByText("Ada has changed it meanwhile")).toBeDefined();
    await user.click(screen.getByRole("button", { name: button }));
    if (button === "Show the new version") {
      expect(field).toHaveProperty("value", "Night");
      await user.click(screen.getByRole("button", { name: "Save" }));
    }
    await vi.waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(stored.at(-1)?.body).toMatchObject({ name, mode });
  });

  it("lists decisions with their goals, and removes rules", async () => {
    const stored = answering([LOW], [SENT]);
    const { user } = open();
    const row = (await screen.findByText("Sent to dock")).closest("tr") as HTMLElement;
    expect(within(row).getByRole("link", { name: "See the goal" }).getAttribute("href")).toBe(
      "/ui/goals/3f0c",
    );
    await user.click(screen.getByRole("button", { name: "Remove Low battery" }));
    const dialog = await screen.findByRole("dialog", { name: "Remove Low battery?" });
    await user.click(within(dialog).getByRole("button", { name: "Remove" }));
    await screen.findByText("No rules");
    expect(stored).toEqual([{ id: "low-battery", body: null }]);
  });
});
