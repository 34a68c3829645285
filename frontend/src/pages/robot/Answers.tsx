import { useEffect, useState } from "react";
import { createGoalsApi } from "../../api/goals";
import { useFleet } from "../../fleet/context";
import { useScene, useServices } from "../../store/context";
import { useFreshness } from "../../store/freshness";
import { isTerminal } from "../../store/goals";

/**
 * Asks, whenever the page reconnects or the scene stops or goes on, for what the snapshot does not hold; events
 * tell of what changes later. Shows nothing. The simulator is asked for where there is a true pose, which nobody else tells;
 * the stored poses of a goal that ran already when the page was opened, once.
 */
export function Answers() {
  const { http } = useFleet();
  const { gateway, scene, store } = useServices();
  const freshness = useFreshness("scene");
  const simulated = useScene((scene) => scene?.frame === "world");

  useEffect(() => {
    if (simulated && freshness !== "offline") return ask(gateway.simulator(), store.setSimulator);
  }, [gateway, store, freshness, simulated]);

  const [goalId] = useState(() => store.get("courses").find(({ status }) => !isTerminal(status))?.goal_id);
  useEffect(() => {
    if (goalId !== undefined) return ask(createGoalsApi(http).poses(goalId), (poses) => scene.recall(poses));
  }, [http, scene, goalId]);

  return null;
}

/** Hands on the answer unless the returned function was called before it came. */
function ask<Answer>(answer: Promise<Answer>, take: (answer: Answer) => void): () => void {
  let wanted = true;
  // Without an answer it is as before; what is wrong with the connection is said at the top.
  answer.then((value) => wanted && take(value)).catch(() => {});
  return () => {
    wanted = false;
  };
}
