import { expect, test } from "vitest";
import type { Quality } from "../src/api/graph";
import { conflictsOf, describeQuality, incompatibilities, warningOf } from "../src/graph/qos";
import { endpoint, quality, topic } from "./graph";

function reasons(offered: Partial<Quality>, requested: Partial<Quality>): string[] {
  return incompatibilities(quality(offered), quality(requested));
}

test.each<[Partial<Quality>, Partial<Quality>, string[]]>([
  [{}, {}, []],
  [{ reliability: "reliable" }, { reliability: "best_effort" }, []],
  [{ reliability: "best_effort" }, { reliability: "reliable" }, ["reliable, where best effort is offered"]],
  [{ durability: "transient_local" }, { durability: "volatile" }, []],
  [
    { durability: "volatile" },
    { durability: "transient_local" },
    ["transient local, where volatile is offered"],
  ],
  [{ liveliness: "manual_by_topic" }, { liveliness: "automatic" }, []],
  [
    { liveliness: "automatic" },
    { liveliness: "manual_by_topic" },
    ["manual by topic, where automatic is offered"],
  ],
  [{ deadline_s: 0.1 }, { deadline_s: 0.2 }, []],
  [{ deadline_s: 0.2 }, { deadline_s: 0.1 }, ["a deadline of 0.1 s, where one of 0.2 s is offered"]],
  [{ deadline_s: null }, { deadline_s: 1 }, ["a deadline of 1 s, where none is offered"]],
  [{ deadline_s: 1 }, { deadline_s: null }, []],
  // What nobody knows is no conflict.
  [{ reliability: "unknown", durability: "unknown" }, { durability: "transient_local" }, []],
  // Neither depth nor lifespan have to fit.
  [{ depth: 1, lifespan_s: 1 }, { depth: 10, lifespan_s: null }, []],
])("what offers %j serves who asks for %j but for %j", (offered, requested, expected) => {
  expect(reasons(offered, requested)).toEqual(expected);
});

test("a topic's conflicts name both sides, and nobody else", () => {
  const camera = topic("/image", {
    publishers: [endpoint("/camera", { reliability: "best_effort" }), endpoint("/replay")],
    subscribers: [endpoint("/recorder"), endpoint("/viewer", { reliability: "best_effort" })],
  });
  expect(conflictsOf(camera)).toEqual([
    {
      publisher: camera.publishers[0],
      subscriber: camera.subscribers[0],
      reasons: ["reliable, where best effort is offered"],
    },
  ]);
  expect(warningOf(camera)).toBe("incompatible QoS");
});

test("a topic with two types has a warning, one where all is well has none", () => {
  expect(warningOf(topic("/mixed", { types: ["a/msg/A", "b/msg/B"] }))).toBe("more than one type");
  expect(
    warningOf(topic("/fine", { publishers: [endpoint("/a")], subscribers: [endpoint("/b")] })),
  ).toBeNull();
});

test("a quality is described without what nobody knows", () => {
  expect(describeQuality(quality())).toBe("reliable, volatile");
  expect(
    describeQuality(
      quality({
        history: "keep_last",
        depth: 10,
        deadline_s: 0.5,
        lifespan_s: 2,
        durability: "transient_local",
      }),
    ),
  ).toBe("reliable, transient local, keep last 10, deadline 0.5 s, lifespan 2 s");
});
