import { describe, expect, it } from "vitest";
import { GONE_AFTER_MS, initialConnection, nextConnection } from "../src/stream/connection";

const live = nextConnection(initialConnection(0), { kind: "snapshot" }, 100);

describe("connection", () => {
  it("is live when a snapshot has come, not before", () => {
    expect(initialConnection(0).phase).toBe("connecting");
    expect(live).toEqual({ phase: "live", since: 100, reason: null });
    expect(nextConnection(live, { kind: "snapshot" }, 200)).toBe(live);
  });

  it("is reconnecting from the moment it closes, since then", () => {
    const closed = nextConnection(live, { kind: "closed" }, 500);
    expect(closed).toEqual({ phase: "reconnecting", since: 500, reason: null });
    expect(nextConnection(closed, { kind: "closed" }, 900)).toBe(closed);
  });

  it("keeps the reason that the gateway gave", () => {
    const closing = nextConnection(live, { kind: "closing", reason: "shutting_down" }, 500);
    expect(nextConnection(closing, { kind: "closed" }, 510).reason).toBe("shutting_down");
  });

  it("is gone after ten seconds, and live again with the next snapshot", () => {
    const closed = nextConnection(live, { kind: "closed" }, 500);
    expect(nextConnection(closed, { kind: "tick" }, 500 + GONE_AFTER_MS - 1)).toBe(closed);
    const gone = nextConnection(closed, { kind: "tick" }, 500 + GONE_AFTER_MS);
    expect(gone).toEqual({ phase: "gone", since: 500, reason: null });
    expect(nextConnection(gone, { kind: "tick" }, 99_000)).toBe(gone);
    expect(nextConnection(gone, { kind: "snapshot" }, 99_000).phase).toBe("live");
  });

  it("is gone too where it never was live", () => {
    expect(nextConnection(initialConnection(0), { kind: "tick" }, GONE_AFTER_MS).phase).toBe("gone");
  });
});
