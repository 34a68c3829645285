import { useQueryClient } from "@tanstack/react-query";
import { useCallback, useMemo, useState } from "react";
import type { Json } from "../api/jsonSchema";
import {
  asForm,
  asJson,
  type Draft,
  newDraft,
  outgoing,
  withDefaults,
  withField,
  withText,
} from "./form/draft";
import type { MessageShape, Path, Value } from "./form/shapes";
import type { FieldError } from "./form/write";

const DRAFT = "draft";

/**
 * The goal that is being written for an action. It outlives the page: one who looks at a goal and comes back finds the
 * form as it was.
 *
 * @param starting What to begin with.
 */
export function useDraft(action: string, shape: MessageShape, starting: Json) {
  const client = useQueryClient();
  const [draft, setDraft] = useState(
    () => client.getQueryData<Draft>([DRAFT, action]) ?? newDraft(shape, starting),
  );
  const update = useCallback(
    (change: (before: Draft) => Draft) =>
      setDraft((before) => {
        const next = change(before);
        client.setQueryDefaults([DRAFT], { gcTime: Number.POSITIVE_INFINITY });
        client.setQueryData([DRAFT, action], next);
        return next;
      }),
    [client, action],
  );
  return useDraftOf(draft, update, shape);
}

/**
 * What a form of a message needs of the draft that it edits.
 *
 * @param update Changes the draft, wherever that is kept. It has to stay the same function.
 */
export function useDraftOf(
  draft: Draft,
  update: (change: (before: Draft) => Draft) => void,
  shape: MessageShape,
) {
  const [hidden, setHidden] = useState<readonly FieldError[]>([]);
  const out = useMemo(() => outgoing(draft, shape), [draft, shape]);

  return {
    draft,
    ...out,
    /** Why the JSON cannot be shown as a form. */
    hidden,
    change: useCallback(
      (path: Path, value: Value) => update((before) => withField(before, path, value)),
      [update],
    ),
    setText: (text: string) => {
      setHidden([]);
      update((before) => withText(before, text));
    },
    setMode: (mode: Draft["mode"]) => {
      const next = mode === "json" ? asJson(draft, shape) : asForm(draft, shape);
      if ("mode" in next) update(() => next);
      setHidden("mode" in next ? [] : next);
    },
    begin: (message: Json) => {
      setHidden([]);
      update((before) => {
        const next = newDraft(shape, message);
        return before.mode === "json" ? asJson(next, shape) : next;
      });
    },
    clear: () => {
      setHidden([]);
      update((before) => withDefaults(before, shape));
    },
    refuse: (refused: readonly FieldError[]) => update((before) => ({ ...before, refused })),
  };
}

/** What a form begins with where the defaults alone show nothing: an order that can be watched, a battery that charges. */
const STARTING: Record<string, Json> = {
  "action_tutorials_interfaces/action/ConnectToChargingDock": {
    desired_battery_state: { power_supply_status: "CHARGING" },
  },
  "action_tutorials_interfaces/action/Fibonacci": { order: 10 },
  "test_msgs/action/Fibonacci": { order: 10 },
};

export function startingMessage(type: string): Json {
  return STARTING[type] ?? {};
}
