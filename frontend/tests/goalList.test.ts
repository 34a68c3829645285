import type { GoalPage, LiveGoal } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { goalExportUrl, goalsExportUrl } from "../src/api/goals";
import { goalFilter, matches, toQuery } from "../src/goals/filter";
import { mergeGoalList } from "../src/goals/useGoalList";
import { at, goal, START } from "./events";

const read = (text: string) => goalFilter.read(new URLSearchParams(text));

describe("the filter", () => {
  it("is read from the address and written to it", () => {
    const text =
      "robot=%2Frobot1&action=%2Fdock&action=%2Fundock&status=running&status=lost&error=blocked&origin=external&last=24h&id=4f1c&tag=blocked&tag=late";
    expect(goalFilter.write(read(text)).toString()).toBe(text);
    expect(read(text).actions).toEqual(["/dock", "/undock"]);
    expect(goalFilter.isInitial(read(text))).toBe(false);
    expect(goalFilter.isInitial(read(""))).toBe(true);
  });

  it("leaves out what it does not understand", () => {
    expect(read("status=failed&origin=me&last=2y&since=yesterday&robot=&action=&page=3&id=xyz")).toEqual(
      goalFilter.initial,
    );
  });

  it("keeps a group, which the gateway resolves", () => {
    expect(goalFilter.write(read("group=Hall+1")).toString()).toBe("group=Hall+1");
    expect(toQuery(read("group=Hall+1"), START)).toEqual({ group: "Hall 1" });
  });

  it("takes every state before the end as running", () => {
    expect(read("status=executing&status=pending").states).toEqual(["running"]);
    expect(toQuery(read("status=executing&status=aborted"), START).status).toEqual([
      "pending",
      "accepted",
      "executing",
      "canceling",
      "aborted",
    ]);
  });

  it("asks the gateway for times in its own", () => {
    expect(toQuery(read("last=24h"), START)).toEqual({ since: "2026-11-20T03:32:40.000Z" });
    const query = toQuery(read("since=2026-11-21T04:00:00%2B01:00&until=2026-11-21T05:00:00Z"), START);
    expect(query).toEqual({ since: "2026-11-21T03:00:00.000Z", until: "2026-11-21T05:00:00.000Z" });
  });

  it("says of a goal what the gateway would", () => {
    const one = goal("a", { action_name: "/robot1/dock", status: "canceling", created_at: at(0) });
    const fits = (text: string) => matches(one, read(text), START + 60_000);
    expect(
      ["robot=/robot1", "robot=/", "action=/robot1/dock", "status=running", "last=24h"].map(fits),
    ).toEqual(Array(5).fill(true));
    expect(["robot=/robot", "action=/dock", "status=lost", "origin=external"].map(fits)).toEqual(
      Array(4).fill(false),
    );
    const failed = goal("b", { error: { code: "blocked", detail: "by a chair" } });
    expect(matches(failed, read("error=lost&error=blocked"), START)).toBe(true);
    expect(matches(failed, read("error=lost"), START) || fits("error=blocked")).toBe(false);
    expect(fits(`since=${at(0)}&until=${at(1)}`)).toBe(true);
    expect(fits(`since=${at(1)}`)).toBe(false);
    expect(fits(`until=${at(0)}`)).toBe(false);
    const known = goal("3f0c7b2e-9a01-4000-8000-000000000000");
    expect(
      ["3f0c", "3F0C7B2E9A", known.goal_id].map((id) => matches(known, read(`id=${id}`), START)),
    ).toEqual(Array(3).fill(true));
    expect(matches(known, read("id=7b2e"), START)).toBe(false);
  });

  it("goes into the addresses of exports", () => {
    expect(
      goalsExportUrl(toQuery(read("robot=/r&status=lost&action=/a&action=/b&error=x"), START), "csv"),
    ).toBe("/goals/export?format=csv&robot=%2Fr&action=%2Fa&action=%2Fb&status=lost&error=x");
    expect(goalExportUrl("3f0c", "json")).toBe("/goals/3f0c/export?format=json");
  });
});

describe("the list", () => {
  const all = () => true;
  const page = (goals: LiveGoal[], next_cursor: string | null = null): GoalPage => ({
    goals: goals.map((each) => ({
      ...each,
      tags: each.goal_id === "a" ? ["blocked"] : [],
    })) as GoalPage["goals"],
    next_cursor,
  });
  const created = (id: string, seconds: number, change = {}) =>
    goal(id, { created_at: at(seconds), updated_at: at(seconds), ...change });
  const ids = (goals: LiveGoal[]) => goals.map(({ goal_id }) => goal_id);

  it("has what is loaded and what came since, newest first, each once", () => {
    const known = [created("new", 9), created("b", 2)];
    expect(ids(mergeGoalList([page([created("b", 2), created("a", 1)])], known, all))).toEqual([
      "new",
      "b",
      "a",
    ]);
  });

  it("shows a goal as the newer of both tells it", () => {
    const ended = created("a", 1, { status: "succeeded", updated_at: at(5) });
    expect(mergeGoalList([page([created("a", 1)])], [ended], all)[0]?.status).toBe("succeeded");
    expect(mergeGoalList([page([ended])], [created("a", 1)], all)[0]?.status).toBe("succeeded");
  });

  it("keeps the tags, which the stream does not tell", () => {
    const pages = [page([created("b", 2), created("a", 1)])];
    const ended = created("a", 1, { status: "succeeded", updated_at: at(5) });
    const tagged = mergeGoalList(pages, [ended, created("new", 9)], (each) =>
      matches(each, read("tag=late&tag=blocked"), START),
    );
    expect(tagged.map(({ goal_id, status, tags }) => [goal_id, status, tags])).toEqual([
      ["a", "succeeded", ["blocked"]],
    ]);
  });

  it("keeps what is known of a goal that the stream knows of one event alone", () => {
    const one = created("a", 7, { action_type: "", status: "aborted" });
    const [shown] = mergeGoalList([page([created("a", 1, { action_type: "t" })])], [one], all);
    expect([shown?.status, shown?.created_at, shown?.action_type]).toEqual(["aborted", at(1), "t"]);
  });

  it("leaves no hole between what is loaded and older goals that the stream knows", () => {
    const known = [created("older", 1)];
    expect(ids(mergeGoalList([page([created("b", 5)], "more")], known, all))).toEqual(["b"]);
    expect(ids(mergeGoalList([page([created("b", 5)])], known, all))).toEqual(["b", "older"]);
  });

  it("drops a goal that no longer fits", () => {
    const ended = created("a", 1, { status: "succeeded", updated_at: at(5) });
    const running = (each: LiveGoal) => matches(each, read("status=running"), START);
    expect(mergeGoalList([page([created("a", 1)])], [ended], running)).toEqual([]);
  });
});
