import { useEffect } from "react";

/** Keeps the screen on, where the browser can. The browser ends it when the page is hidden. */
export function useWakeLock(): void {
  useEffect(() => {
    if (!("wakeLock" in navigator)) return;
    let held: Promise<WakeLockSentinel | null> = Promise.resolve(null);
    const hold = () => {
      // Refused where the battery of the computer is low, for example.
      if (!document.hidden) held = navigator.wakeLock.request("screen").catch(() => null);
    };
    hold();
    document.addEventListener("visibilitychange", hold);
    return () => {
      document.removeEventListener("visibilitychange", hold);
      void held.then((lock) => lock?.release());
    };
  }, []);
}
