import { useEffect } from "react";

const EVERY_MS = 5 * 60_000;
const ANSWER_MS = 5_000;
const KEY = "dock-gateway-loaded-for";

/** Loads the page again once the gateway has another build of the dashboard: after an outage, and now and then. */
export function useNewBuild(live: boolean): void {
  useEffect(() => {
    if (!live) return;
    const look = () =>
      void newBuild().then((build) => {
        if (build !== null && isFirst(build)) window.location.reload();
      });
    look();
    const timer = setInterval(look, EVERY_MS);
    return () => clearInterval(timer);
  }, [live]);
}

/** The script that the gateway serves; null where it is the one that runs here, or the gateway does not say. */
export async function newBuild(): Promise<string | null> {
  const running = document.querySelector("script[type=module][src]")?.getAttribute("src");
  try {
    const answer = await fetch("/", { cache: "no-cache", signal: AbortSignal.timeout(ANSWER_MS) });
    const served = /<script type="module"[^>]* src="([^"]+)"/.exec(await answer.text())?.[1];
    return !answer.ok || running == null || served === undefined || served === running ? null : served;
  } catch {
    return null;
  }
}

/** Once for each build: behind a proxy that serves an old page, the page would be loaded for ever. */
function isFirst(build: string): boolean {
  try {
    if (sessionStorage.getItem(KEY) === build) return false;
    sessionStorage.setItem(KEY, build);
    return true;
  } catch {
    return false;
  }
}
