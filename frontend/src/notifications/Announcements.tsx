import type { Alert } from "@dock-gateway/client";
import { useEffect, useRef } from "react";
import { useNavigate } from "react-router";
import { siteKey } from "../api/site";
import { useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import type { Naming } from "../fleet/names";
import { robotPath } from "../fleet/names";
import { isCovered } from "../fleet/robotChoice";
import { notify, type Preferences, playSound, usePreferences } from "./announce";

/** The tab that announces alerts holds it, so that several tabs make one sound. */
const LOCK = siteKey("dock-gateway-announcer");

/** Announces each alert that begins while the page is open, as this browser is set to. */
export function Announcements(): null {
  const chosen = usePreferences();
  const { desktop, sound } = chosen;
  const leads = useLeadership(desktop || sound);
  const live = useFleetLive();
  const alerts = useFleetTopic("alerts");
  const naming = useNaming();
  const navigate = useNavigate();
  const known = useRef<ReadonlySet<string> | null>(null);
  useEffect(() => {
    if (!live) return;
    const before = known.current;
    known.current = new Set(alerts.map(({ id }) => id));
    if (before === null || !leads.current) return; // those of before are on the page
    const fresh = alerts.filter((alert) => !before.has(alert.id) && isWanted(alert, chosen, naming));
    if (desktop)
      for (const alert of fresh)
        notify({
          tag: siteKey(alert.id),
          title: alert.robot === null ? alert.title : `${naming.nameOf(alert.robot)}: ${alert.title}`,
          body: alert.detail,
          critical: alert.severity === "critical",
          onPress: () => void navigate(alert.robot === null ? "/" : robotPath(alert.robot)),
        });
    if (sound && fresh.length > 0) void playSound(fresh.some(({ severity }) => severity === "critical"));
  }, [live, alerts, chosen, desktop, sound, naming, navigate, leads]);
  return null;
}

/** Whether an alert is to be announced; one of the gateway itself concerns everybody. */
export function isWanted(alert: Alert, chosen: Preferences, naming: Naming): boolean {
  if (alert.acknowledged !== null || (alert.severity === "warning" && !chosen.warnings)) return false;
  return alert.robot === null || isCovered(chosen.robots, alert.robot, naming.groupsOf(alert.robot));
}

/** Whether this tab is the one that announces; without locks, which need HTTPS, each tab is. */
function useLeadership(wanted: boolean) {
  const leads = useRef(false);
  useEffect(() => {
    if (!wanted) return;
    if (navigator.locks === undefined) {
      leads.current = true;
      return;
    }
    const leaving = new AbortController();
    const left = new Promise<void>((resolve) => leaving.signal.addEventListener("abort", () => resolve()));
    const hold = () => {
      leads.current = true;
      return left;
    };
    navigator.locks.request(LOCK, { signal: leaving.signal }, hold).catch(() => {});
    return () => {
      leads.current = false;
      leaving.abort();
    };
  }, [wanted]);
  return leads;
}
