/** The tabs of a robot's page, as its address names them. */
export const OPERATE = "operate";
export const DEVELOPER = "developer";

export type Tab = typeof OPERATE | typeof DEVELOPER;

export function readTab(query: URLSearchParams): Tab {
  return query.get("tab") === DEVELOPER ? DEVELOPER : OPERATE;
}

/** The query with another tab; the first one is left out. */
export function withTab(query: URLSearchParams, tab: Tab): URLSearchParams {
  const changed = new URLSearchParams(query);
  if (tab === OPERATE) changed.delete("tab");
  else changed.set("tab", tab);
  return changed;
}

/** Where a robot's page is. */
export function robotPath(robot: string, tab: Tab = OPERATE): string {
  const path = `/ui/robot?robot=${encodeURIComponent(robot).replaceAll("%2F", "/")}`;
  return tab === OPERATE ? path : `${path}&tab=${tab}`;
}
