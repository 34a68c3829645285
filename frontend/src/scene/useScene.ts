import type { Scene } from "../api/types";
import { useAtTime } from "../clock/clock";
import { useServices } from "../store/context";

const INTERVAL_MS = 400;

/** What words and buttons read off the latest scene, rendered anew where it is another; the picture does without React. */
export function useScene<Part extends string | number | boolean>(read: (scene: Scene | null) => Part): Part {
  const { scene: buffer } = useServices();
  return useAtTime(() => read(buffer.latest), INTERVAL_MS);
}
