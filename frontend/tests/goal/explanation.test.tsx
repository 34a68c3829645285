import { MantineProvider } from "@mantine/core";
import { render, screen } from "@testing-library/react";
import { describe, expect, it } from "vitest";
import { GoalExplanation } from "../../src/goal/facts";
import { goal } from "../events";

const show = (...parameters: Parameters<typeof goal>) =>
  render(
    <MantineProvider>
      <GoalExplanation goal={goal(...parameters)} />
    </MantineProvider>,
  );

describe("why a goal stands as it does", () => {
  it("is no alert where a stop canceled it, and names who pressed it", () => {
    show("a", {
      status: "canceled",
      error: { code: "stopped", detail: "a stop was requested by Ada" },
    });
    expect(screen.getByText("Canceled by a stop. A stop was requested by Ada.")).toBeDefined();
    expect(screen.queryByRole("alert")).toBeNull();
  });

  it("is an alert where it failed: what to do first, the details folded", () => {
    show("a", { status: "aborted", error: { code: "blocked", detail: "moved 0.01 m in 5 s" } });
    const alert = screen.getByRole("alert", { name: "Docking failed: robot was blocked." });
    expect(alert.textContent).toMatch(/something is in its way.*DetailsMoved 0.01 m in 5 sCode: blocked/);
    expect(alert.querySelector("details")?.open).toBe(false);
  });
});
