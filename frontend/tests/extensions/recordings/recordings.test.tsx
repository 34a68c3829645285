import { act, screen } from "@testing-library/react";
import { expect, it, vi } from "vitest";
import { LinkedRecording } from "../../../src/extensions/recordings/LinkedRecording";
import { RecordedPicture, RecordingButton } from "../../../src/extensions/recordings/RecordingButton";
import { recordingUrl, thumbnailUrl } from "../../../src/extensions/recordings/requests";
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

it("asks the site on the page of one", () => {
  window.history.replaceState(null, "", "/sites/berlin/");
  expect(thumbnailUrl("a")).toBe("/sites/berlin/goals/a/thumbnail");
  expect(recordingUrl("a")).toBe("/sites/berlin/goals/a/recording.mcap");
  window.history.replaceState(null, "", "/");
});
