import { render, screen } from "@testing-library/react";
import { Suspense } from "react";
import { expect, it, vi } from "vitest";

// The other tests have a simpler one: see setup.ts.
const { lazyPart } = await vi.importActual<typeof import("../src/ui/lazyPart")>("../src/ui/lazyPart");

function show() {
  const Part = lazyPart(async () => ({ default: () => <p>here</p> }));
  render(
    <Suspense fallback="waiting">
      <Part />
    </Suspense>,
  );
}

it("is shown where the gateway answers that it has lost ROS", async () => {
  vi.stubGlobal("fetch", async () => Response.json({ status: "ros_unavailable" }, { status: 503 }));
  show();
  expect(await screen.findByText("here")).toBeDefined();
});

it("waits where only a proxy answers", async () => {
  vi.useFakeTimers();
  const page = () => new Response("<html></html>", { status: 503, headers: { "Content-Type": "text/html" } });
  const fetched = vi.fn(async () => page());
  vi.stubGlobal("fetch", fetched);
  show();
  await vi.advanceTimersByTimeAsync(9000);
  expect(fetched.mock.calls.length).toBeGreaterThan(2);
  expect(screen.queryByText("here")).toBeNull();
});
