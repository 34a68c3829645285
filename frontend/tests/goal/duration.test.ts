import { describe, expect, it } from "vitest";
import { durationWords } from "../../src/goal/words";
import { at, goal, START } from "../events";

describe("the duration of a goal", () => {
  it("is in whole seconds while it runs, so that all pages say the same", () => {
    const running = goal("a", { updated_at: at(5) });
    const later = [100, 900].map((ms) => durationWords(running, START + 7000 + ms));
    expect(later).toEqual(["7 s", "7 s"]);
    expect(durationWords(running, START + 65_900)).toBe("1 min 05 s");
    expect(durationWords(running, START - 50)).toBe("0 s");
  });

  it("is from its creation to its end, as it is exported", () => {
    const ended = goal("a", { status: "lost", updated_at: at(9), finished_at: at(2.5) });
    expect(durationWords(ended, START + 60_000)).toBe("2.5 s");
  });
});
