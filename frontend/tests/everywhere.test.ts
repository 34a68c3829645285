import { describe, expect, it, vi } from "vitest";
import { stopThese } from "../src/stop/everywhere";
import { stopReport } from "./events";

describe("a Stop of many robots", () => {
  it("takes as few requests as their names fit into, and leaves none out", async () => {
    const names = Array.from({ length: 300 }, (_, index) => `/hall/${"x".repeat(40)}${index}`);
    const stop = vi.fn(async (robots: readonly string[] | null) =>
      stopReport({ canceling: [`${robots?.length}`] }),
    );
    const report = await stopThese(stop, names);
    expect(stop.mock.calls.flatMap(([robots]) => robots)).toEqual(names);
    expect(stop.mock.calls.length).toBeLessThan(7);
    for (const [robots] of stop.mock.calls) {
      const query = new URLSearchParams((robots ?? []).map((robot) => ["robot", robot]));
      expect(`${query}`.length).toBeLessThanOrEqual(4000);
    }
    expect(report.canceling).toHaveLength(stop.mock.calls.length);
    expect((await stopThese(stop, ["/a"])).canceling).toEqual(["1"]);
  });

  it("counts each robot of a request that failed", async () => {
    const names = Array.from({ length: 200 }, (_, index) => `/${"x".repeat(40)}${index}`);
    const stop = vi.fn().mockResolvedValueOnce(stopReport()).mockRejectedValue(new Error("down"));
    const failed = (await stopThese(stop, names)).failed.map(({ robot }) => robot);
    expect(failed).toEqual(names.slice(stop.mock.calls[0]?.[0].length));
    expect(failed.length).toBeGreaterThan(50);
  });
});
