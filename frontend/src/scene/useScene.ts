import type { Scene } from "../api/types";
import { useAtTime } from "../store/clock";
import { useServices } from "../store/context";

export interface SeenScene {
  /** Null until a first one has come. */
  scene: Scene | null;
  fresh: boolean;
}

const INTERVAL_MS = 400;

/** What words and buttons read off the latest scene, rendered anew where it is another; the picture does without React. */
export function useScene<Part extends string | number | boolean>(read: (seen: SeenScene) => Part): Part {
  const { scene: buffer } = useServices();
  return useAtTime(
    () => read({ scene: buffer.latest, fresh: buffer.isFresh(performance.now()) }),
    INTERVAL_MS,
  );
}
