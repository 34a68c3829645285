import { act, fireEvent, screen } from "@testing-library/react";
import { expect, it, vi } from "vitest";
import GoalLog, { mostTelling, readable } from "../../../src/extensions/recordings/GoalLog";
import { LinkedRecording } from "../../../src/extensions/recordings/LinkedRecording";
import { RecordedPicture, RecordingButton } from "../../../src/extensions/recordings/RecordingButton";
import { type GoalReplay, recordingUrl, thumbnailUrl } from "../../../src/extensions/recordings/requests";
import { goal, START } from "../../events";
import { fakeGateway, renderWithin, robotServices } from "../../page";

it("has the recording with its size once it is complete, and says why there is none", async () => {
  let recording: object = {
    state: "running",
    size_bytes: null,
    picture: false,
    reason: "The goal is being recorded.",
  };
  vi.stubGlobal("fetch", async (request: Request) =>
    request.url.endsWith("/goals/a") ? Response.json({ recording }) : Response.json({}, { status: 404 }),
  );
  const ended = goal("a", { status: "succeeded", finished_at: new Date(START).toISOString() });
  renderWithin(
    robotServices(fakeGateway()).fleet,
    <>
      <RecordedPicture goal={ended} />
      <RecordingButton goal={ended} />
    </>,
  );
  expect((await screen.findByRole("button", { name: "Recording" })).getAttribute("aria-disabled")).toBe(
    "true",
  );
  expect(screen.getByText("The goal is being recorded.")).toBeDefined();
  recording = { state: "complete", size_bytes: 3_400_000, picture: true, reason: null };
  const link = await screen.findByRole("link", { name: "Recording, 3.4 MB" }, { timeout: 5000 });
  expect(link.getAttribute("href")).toBe("/goals/a/recording.mcap");
  const picture = screen.getByRole("img", { name: "What the robot's camera saw last" });
  expect(picture.getAttribute("src")).toBe("/goals/a/thumbnail");
});

it("is beside a link to a goal that has one, asked for once that is in sight", async () => {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const id = request.url.slice(request.url.lastIndexOf("/") + 1);
    asked.push(id);
    const has = { state: "complete", size_bytes: 12_000, picture: false, reason: null };
    return Response.json({ recording: id === "a" ? has : { ...has, state: "none", size_bytes: null } });
  });
  const appear: (() => void)[] = [];
  vi.stubGlobal(
    "IntersectionObserver",
    class {
      constructor(tell: (entries: { isIntersecting: boolean }[]) => void) {
        appear.push(() => tell([{ isIntersecting: true }]));
      }
      observe() {}
      disconnect() {}
    },
  );
  renderWithin(
    robotServices(fakeGateway()).fleet,
    <>
      <LinkedRecording goalId="a" />
      <LinkedRecording goalId="b" />
    </>,
  );
  expect(asked).toEqual([]);
  act(() => appear.forEach((each) => void each()));
  const link = await screen.findByRole("link", { name: "Recording, 12 kB" });
  expect(link.getAttribute("href")).toBe("/goals/a/recording.mcap");
  expect(asked).toEqual(["a", "b"]);
  expect(screen.getAllByRole("link")).toHaveLength(1);
});

const line = (number: number, level: GoalReplay["log"][number]["level"] = "info") => ({
  offset_s: number,
  level,
  node: "robot1.docking_server",
  text: `line ${number}`,
});

it("has the log of a goal that has ended: its last lines, what was warned of before, and all on demand", async () => {
  const recording = { state: "complete", size_bytes: 12_000, picture: false, reason: null };
  const log = [line(0), line(1, "error"), ...Array.from({ length: 20 }, (_, index) => line(index + 2))];
  vi.stubGlobal("fetch", async (request: Request) =>
    Response.json(
      request.url.endsWith("/replay") ? { scans: [], velocity: [], battery: [], log } : { recording },
    ),
  );
  const ended = goal("a", { status: "aborted", finished_at: new Date(START).toISOString() });
  renderWithin(robotServices(fakeGateway()).fleet, <GoalLog goal={ended} />);
  const items = async () => (await screen.findAllByRole("listitem")).map(({ textContent }) => textContent);
  expect((await items())[0]).toBe("1.0 sError: line 1robot1.docking_server");
  expect(await items()).toHaveLength(9);
  fireEvent.click(screen.getByRole("button", { name: "Show all 22 lines" }));
  expect(await items()).toHaveLength(22);
});

it("shows a short log as it is", () => {
  const log = [line(0), line(1, "warning"), line(2)];
  expect(mostTelling(log)).toEqual(log);
});

it("leaves out the goal's id, one line again and again, and what another line says, too", () => {
  const log = [
    { ...line(0), text: "Goal a: looking" },
    { ...line(1), text: "NOT CHARGING" },
    { ...line(2), text: "NOT CHARGING" },
    { ...line(3, "error"), text: "Goal a aborted: no charge" },
    { ...line(3.05, "error"), node: "robot1/docking", text: "no charge" },
    { ...line(9), text: "no charge" },
  ];
  expect(readable(log, "a").map(({ text, times }) => [text, times])).toEqual([
    ["looking", undefined],
    ["NOT CHARGING", 2],
    ["Goal aborted: no charge", undefined],
    ["no charge", undefined],
  ]);
});

it("asks the site on the page of one", () => {
  window.history.replaceState(null, "", "/sites/berlin/");
  expect(thumbnailUrl("a")).toBe("/sites/berlin/goals/a/thumbnail");
  expect(recordingUrl("a")).toBe("/sites/berlin/goals/a/recording.mcap");
  window.history.replaceState(null, "", "/");
});
