import { useEffect } from "react";
import { useScene } from "../scene/useScene";
import { useServices } from "../store/context";
import { useFreshness } from "../store/freshness";

/**
 * Asks, whenever the page is connected anew or the scene stops or goes on, for what the snapshot does not hold; events
 * tell of what changes later. Shows nothing. The simulator is asked for where there is a true pose, which nobody else tells.
 */
export function Answers() {
  const { gateway, store } = useServices();
  const freshness = useFreshness("scene");
  const simulated = useScene((scene) => scene?.frame === "world");

  useEffect(() => {
    if (simulated && freshness !== "offline") return ask(gateway.simulator(), store.setSimulator);
  }, [gateway, store, freshness, simulated]);

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
