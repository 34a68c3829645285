import { useEffect, useState } from "react";
import type { Scene } from "../api/types";
import { useServices } from "../store/context";
import type { SceneBuffer } from "./buffer";

export interface SeenScene {
  /** Null until a first one has come. */
  scene: Scene | null;
  fresh: boolean;
}

/** The latest scene for words and buttons, looked at every `intervalMs`; the picture itself does without React. */
export function useScene(intervalMs = 500): SeenScene {
  const { scene: buffer } = useServices();
  const [seen, setSeen] = useState<SeenScene>(() => look(buffer));

  useEffect(() => {
    const renew = () =>
      setSeen((before) => {
        const now = look(buffer);
        return before.scene === now.scene && before.fresh === now.fresh ? before : now;
      });
    renew();
    const timer = setInterval(renew, intervalMs);
    return () => clearInterval(timer);
  }, [buffer, intervalMs]);
  return seen;
}

function look(buffer: SceneBuffer): SeenScene {
  return { scene: buffer.latest, fresh: buffer.isFresh(performance.now()) };
}
