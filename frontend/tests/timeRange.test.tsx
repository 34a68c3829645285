import { MantineProvider } from "@mantine/core";
import { fireEvent, render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import { MemoryRouter, useLocation } from "react-router";
import { afterEach, describe, expect, it } from "vitest";
import { formatMark } from "../src/battery/view";
import { readViews, renamed, SavedViews, withView, writeViews } from "../src/ui/SavedViews";
import { Time } from "../src/ui/Time";
import { TimeRangeField } from "../src/ui/TimeRangeField";
import { clockOf, dayOf, formatTime, startOfDay, timeAt } from "../src/ui/time";
import { ANY_TIME, boundsOf, isEmpty, ownDates, type TimeRange, timeRange } from "../src/ui/timeRange";
import { setZone, shownZone, zoneName } from "../src/ui/zone";

const NOON = Date.parse("2026-11-21T12:34:56Z");
const HOUR = 3_600_000;

afterEach(() => {
  setZone("local");
  localStorage.clear();
});

describe("times", () => {
  it("are shown in UTC where that was chosen, with 24 hours a day", () => {
    setZone("utc");
    expect(formatTime(Date.parse("2026-11-21T00:05:06Z"), NOON)).toBe("00:05:06");
    expect(formatTime(NOON + 10 * HOUR, NOON)).toBe("22:34:56");
    expect(formatTime(NOON - 24 * HOUR, NOON)).toMatch(/20.*12:34:56/);
    expect(formatMark(NOON / 1000, 60)).toBe("12:34");
    expect([shownZone(), zoneName()]).toEqual(["utc", "UTC"]);
    expect(localStorage.getItem("dock-gateway-zone")).toBe("utc");
  });

  it("have days and clocks in both zones", () => {
    for (const zone of ["local", "utc"] as const) {
      setZone(zone);
      const day = dayOf(NOON);
      expect(startOfDay(day)).toBeLessThanOrEqual(NOON);
      expect(startOfDay(day, 1)).toBeGreaterThan(NOON);
      expect(timeAt(day, clockOf(NOON))).toBe(NOON - 56_000);
      expect(timeAt(day, "24:00")).toBe(startOfDay(day, 1));
      expect(timeAt(day, "7:05")).toBe(timeAt(day, "07:05"));
      for (const wrong of ["", "7", "25:00", "24:01", "12:60", "noon"]) expect(timeAt(day, wrong)).toBeNull();
      expect(timeAt("", "12:00") ?? timeAt("2026-13-01", "12:00")).toBeNull();
    }
  });
});

describe("a time range", () => {
  const read = (text: string) => timeRange().read(new URLSearchParams(text));

  it("is read from the address and written to it", () => {
    for (const text of ["", "last=today", "last=30d", "since=2026-11-01T00%3A00%3A00Z"]) {
      const parameters = new URLSearchParams();
      timeRange().write(read(text), parameters);
      expect(parameters.toString()).toBe(text);
    }
    expect(read("last=2y&since=yesterday")).toEqual(ANY_TIME);
  });

  it("is whole days but for the last 24 hours", () => {
    setZone("utc");
    const since = (last: string) => new Date(boundsOf(read(`last=${last}`), NOON).since ?? 0).toISOString();
    expect(["today", "24h", "7d", "30d"].map(since)).toEqual([
      "2026-11-21T00:00:00.000Z",
      "2026-11-20T12:34:56.000Z",
      "2026-11-15T00:00:00.000Z",
      "2026-10-23T00:00:00.000Z",
    ]);
    expect(ownDates(read("last=7d"), NOON)).toEqual({
      last: null,
      since: "2026-11-15T00:00:00.000Z",
      until: "2026-11-22T00:00:00.000Z",
    });
  });

  it("takes any dates, with the end of a day as 24:00, and follows the zone", async () => {
    setZone("utc");
    const user = userEvent.setup();
    let latest: TimeRange = ANY_TIME;
    function Page() {
      const [range, setRange] = useState<TimeRange>({ ...ANY_TIME, last: "today" });
      latest = range;
      return <TimeRangeField value={range} onChange={setRange} now={() => NOON} any />;
    }
    render(
      <MantineProvider env="test">
        <Page />
        <Time value={NOON} />
      </MantineProvider>,
    );
    const value = (name: string) => screen.getByLabelText<HTMLInputElement>(name).value;
    await user.click(screen.getByRole("radio", { name: "Dates" }));
    expect([value("From, day"), value("From, time of day")]).toEqual(["2026-11-21", "00:00"]);
    expect([value("Until, day"), value("Until, time of day")]).toEqual(["2026-11-21", "24:00"]);
    fireEvent.change(screen.getByLabelText("From, day"), { target: { value: "2026-11-03" } });
    await user.clear(screen.getByLabelText("Until, time of day"));
    await user.type(screen.getByLabelText("Until, time of day"), "18:30");
    expect(latest).toEqual({
      last: null,
      since: "2026-11-03T00:00:00.000Z",
      until: "2026-11-21T18:30:00.000Z",
    });
    await user.type(screen.getByLabelText("Until, time of day"), "{Backspace}{Tab}");
    expect(value("Until, time of day")).toBe("18:30");
    expect(screen.getByText(/12:34:56/)).toBeDefined();
    await user.click(screen.getByRole("radio", { name: "Local" }));
    expect(screen.getByText(formatTime(NOON))).toBeDefined();
    await user.click(screen.getByRole("radio", { name: "Any" }));
    expect(latest).toEqual(ANY_TIME);
    expect(screen.queryByLabelText("From, day")).toBeNull();
  });

  it("is empty while it ends before it begins", () => {
    const dates = (since: string | null, until: string | null) => ({ last: null, since, until });
    const [one, other] = ["2026-11-29T00:00:00Z", "2026-11-30T00:00:00Z"];
    expect(isEmpty(dates(other, one), NOON)).toBe(true);
    expect(isEmpty(dates(one, one), NOON)).toBe(true);
    for (const range of [dates(one, other), dates(other, null), dates(null, one), ANY_TIME])
      expect(isEmpty(range, NOON)).toBe(false);
  });
});

describe("saved views", () => {
  it("are kept by name, and what is not one is left out", () => {
    const views = withView(withView([], { name: " late ", query: "tag=late" }), { name: "all", query: "" });
    expect(views.map(({ name }) => name)).toEqual(["all", "late"]);
    expect(renamed(views, "late", "all")).toEqual([{ name: "all", query: "tag=late" }]);
    expect(writeViews("goals", views)).toBe(true);
    expect(readViews("goals")).toEqual(views);
    for (const kept of ["", "{", "5", '[null, {"name": 1}, {"name": " ", "query": ""}]']) {
      localStorage.setItem("dock-gateway-views-goals", kept);
      expect(readViews("goals")).toEqual([]);
    }
    const twice = [...views, { name: "late", query: "tag=2" }, "late", { name: "half" }];
    localStorage.setItem("dock-gateway-views-goals", JSON.stringify(twice));
    expect(readViews("goals").map(({ query }) => query)).toEqual(["", "tag=2"]);
  });

  it("are saved, renamed, opened and deleted", async () => {
    const user = userEvent.setup();
    function Page() {
      const { search } = useLocation();
      return (
        <>
          <output>{search}</output>
          <SavedViews page="goals" query={search.slice(1)} />
        </>
      );
    }
    render(
      <MantineProvider env="test">
        <MemoryRouter
          initialEntries={["/ui/goals?tag=late", "/ui/goals"]}
          initialIndex={0}
          useTransitions={false}
        >
          <Page />
        </MemoryRouter>
      </MantineProvider>,
    );
    await user.click(screen.getByRole("button", { name: "Views" }));
    await user.type(screen.getByLabelText("Name of the view"), "Too late{Enter}");
    await user.click(screen.getByRole("button", { name: "Rename Too late" }));
    await user.clear(screen.getByLabelText("New name of Too late"));
    await user.type(screen.getByLabelText("New name of Too late"), "Late{Enter}");
    expect(readViews("goals")).toEqual([{ name: "Late", query: "tag=late" }]);
    await user.click(screen.getByRole("link", { name: "Late" }));
    expect(screen.getByRole("status").textContent).toBe("?tag=late");
    await user.click(screen.getByRole("button", { name: "Views" }));
    await user.click(screen.getByRole("button", { name: "Delete Late" }));
    expect(readViews("goals")).toEqual([]);
  });
});
