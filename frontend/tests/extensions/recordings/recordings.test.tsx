import { screen } from "@testing-library/react";
import { expect, it, vi } from "vitest";
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

it("asks the site on the page of one", () => {
  window.history.replaceState(null, "", "/sites/berlin/");
  expect(thumbnailUrl("a")).toBe("/sites/berlin/goals/a/thumbnail");
  expect(recordingUrl("a")).toBe("/sites/berlin/goals/a/recording.mcap");
  window.history.replaceState(null, "", "/");
});
