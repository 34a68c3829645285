import type { Endpoint, GraphTopic, Quality } from "../api/graph";

/** A subscriber that hears nothing of a publisher, and why, in words that follow "asks for". */
interface Conflict {
  publisher: Endpoint;
  subscriber: Endpoint;
  reasons: string[];
}

// From the weakest to the strongest (DDS 1.4, section 2.2.3): an offer has to be at least what is asked for.
const RELIABILITY = ["best_effort", "reliable"];
const DURABILITY = ["volatile", "transient_local"];
const LIVELINESS = ["automatic", "manual_by_topic"];

/** Why a subscriber that asks for one quality hears nothing of a publisher that offers the other; empty where it does. */
export function incompatibilities(offered: Quality, requested: Quality): string[] {
  const reasons: string[] = [];
  const compare = (order: readonly string[], offer: string, request: string) => {
    const [has, wants] = [order.indexOf(offer), order.indexOf(request)];
    // What is in neither list ("unknown", "system_default") says nothing.
    if (has >= 0 && wants > has) reasons.push(`${words(request)}, where ${words(offer)} is offered`);
  };
  compare(RELIABILITY, offered.reliability, requested.reliability);
  compare(DURABILITY, offered.durability, requested.durability);
  compare(LIVELINESS, offered.liveliness, requested.liveliness);
  if (
    requested.deadline_s !== null &&
    (offered.deadline_s ?? Number.POSITIVE_INFINITY) > requested.deadline_s
  ) {
    const offer = offered.deadline_s === null ? "none" : `one of ${offered.deadline_s} s`;
    reasons.push(`a deadline of ${requested.deadline_s} s, where ${offer} is offered`);
  }
  return reasons;
}

/** Every pair on the topic that does not fit together. */
export function conflictsOf({ publishers, subscribers }: GraphTopic): Conflict[] {
  return subscribers.flatMap((subscriber) =>
    publishers.flatMap((publisher) => {
      const reasons = incompatibilities(publisher.qos, subscriber.qos);
      return reasons.length === 0 ? [] : [{ publisher, subscriber, reasons }];
    }),
  );
}

/** What is wrong with a topic, in a few words; null where nothing is. */
export function warningOf(topic: GraphTopic): string | null {
  if (topic.types.length > 1) return "more than one type";
  return conflictsOf(topic).length > 0 ? "incompatible QoS" : null;
}

/** `reliable, volatile, keep last 10`: what matters of a quality, without what is unknown. */
export function describeQuality(quality: Quality): string {
  const { reliability, durability, history, depth, deadline_s, lifespan_s, liveliness } = quality;
  const parts = [reliability, durability].map(words);
  if (history !== "unknown") parts.push(depth === null ? words(history) : `${words(history)} ${depth}`);
  if (deadline_s !== null) parts.push(`deadline ${deadline_s} s`);
  if (lifespan_s !== null) parts.push(`lifespan ${lifespan_s} s`);
  if (liveliness === "manual_by_topic") parts.push("manual liveliness");
  return parts.join(", ");
}

function words(constant: string): string {
  return constant.replaceAll("_", " ");
}
