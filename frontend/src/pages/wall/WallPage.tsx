import { useElementSize } from "@mantine/hooks";
import { useCallback, useEffect, useMemo, useState } from "react";
import { Link, useNavigate, useSearchParams } from "react-router";
import { attentionOf } from "../../alerts/order";
import { ofSites } from "../../api/places";
import { useFleetLive, useFleetTopic } from "../../fleet/context";
import { isThere } from "../../fleet/words";
import { useStopping } from "../../stop/everywhere";
import { useStopKeys } from "../../stop/keys";
import { usePageTitle } from "../../ui/Section";
import { listed, overviewView } from "../overview/list";
import { Clock, State, WallAlerts } from "./head";
import { gridFor, Tile } from "./Tile";
import { WallMap } from "./WallMap";
import classes from "./wall.module.css";

/** How long each page of robots is shown. */
export const PAGE_MS = 15_000;

/** How long the way out is shown after the mouse has moved. */
const LINK_MS = 4_000;

/** All robots, or those of a group, for a screen on a wall: nothing has to be pressed. */
export default function WallPage() {
  usePageTitle("Wall");
  const [query] = useSearchParams();
  const group = query.get("group") || null;
  const live = useFleetLive();
  useWakeLock();
  useNewBuild(live);
  const stop = useStopping();
  useStopKeys(useCallback(() => void stop(null), [stop]));
  const leave = group === null ? "/" : `/?group=${encodeURIComponent(group)}`;
  const moved = useLeaving(leave);

  const robots = useFleetTopic("robots");
  const alerts = useFleetTopic("alerts");
  const attentions = useMemo(() => attentionOf(alerts), [alerts]);
  const shown = useMemo(() => {
    const view = { ...overviewView.initial, group };
    return listed([...robots.values()].filter(isThere), view, attentions);
  }, [robots, group, attentions]);
  const [only] = shown;
  const { ref, width, height } = useElementSize();
  const grid = gridFor(shown.length, width, height);
  const page = usePage(grid.pages);
  const each = grid.columns * grid.rows;

  return (
    <main className={classes.wall} data-moved={moved || undefined} data-live={live || undefined}>
      <header className={classes.head}>
        <h1>
          {group ?? "All robots"}
          <span className={classes.count}>
            {shown.length}
            {grid.pages > 1 && `, page ${page + 1} of ${grid.pages}`}
          </span>
        </h1>
        <Link to={leave} className={classes.leave ?? ""}>
          Leave (Esc)
        </Link>
        <Clock />
      </header>
      <State />
      <WallAlerts alerts={alerts} group={group} />
      <div className={classes.content}>
        <ul
          ref={ref}
          className={classes.tiles}
          style={{
            gridTemplateColumns: `repeat(${grid.columns}, minmax(0, 1fr))`,
            gridTemplateRows: `repeat(${grid.rows}, minmax(0, 1fr))`,
          }}
        >
          {shown.slice(page * each, (page + 1) * each).map((robot) => (
            <Tile key={robot.name} robot={robot} attention={attentions.get(robot.name) ?? 0} live={live} />
          ))}
          {shown.length === 0 && live && (
            <li className={classes.none}>{group === null ? "No robot yet" : `No robot is in ${group}`}</li>
          )}
        </ul>
        {only !== undefined && shown.length === 1 && !ofSites() && <WallMap robot={only.name} />}
      </div>
    </main>
  );
}

/** The page that is shown; each follows the one before by itself. */
function usePage(pages: number): number {
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    if (pages < 2) return;
    const timer = setInterval(() => setTurn((before) => before + 1), PAGE_MS);
    return () => clearInterval(timer);
  }, [pages]);
  return turn % pages;
}

/** Escape leads back. Whether the mouse has moved just now. */
function useLeaving(to: string): boolean {
  const navigate = useNavigate();
  const [moved, setMoved] = useState(false);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const move = () => {
      setMoved(true);
      clearTimeout(timer);
      timer = setTimeout(() => setMoved(false), LINK_MS);
    };
    const hear = ({ key }: KeyboardEvent) => key === "Escape" && void navigate(to);
    window.addEventListener("pointermove", move);
    window.addEventListener("keydown", hear);
    return () => {
      clearTimeout(timer);
      window.removeEventListener("pointermove", move);
      window.removeEventListener("keydown", hear);
    };
  }, [navigate, to]);
  return moved;
}

/** Keeps the screen on, where the browser can. The browser ends it when the page is hidden. */
function useWakeLock(): void {
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

const EVERY_MS = 5 * 60_000;
const ANSWER_MS = 5_000;
const KEY = "dock-gateway-loaded-for";

/** Loads the page again once the gateway has another build of the dashboard: after an outage, and now and then. */
function useNewBuild(live: boolean): void {
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

/** Once for each build: behind a proxy that serves an old page, the page would be loaded again and again. */
function isFirst(build: string): boolean {
  try {
    if (sessionStorage.getItem(KEY) === build) return false;
    sessionStorage.setItem(KEY, build);
    return true;
  } catch {
    return false;
  }
}
