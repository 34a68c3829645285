import type { Alert } from "@dock-gateway/client";
import { useEffect, useRef } from "react";
import { useNavigate } from "react-router";
import { type Together, together } from "../alerts/order";
import { detailOf, robotsOf } from "../alerts/words";
import { siteKey } from "../api/site";
import { useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import type { Naming } from "../fleet/names";
import { robotPath } from "../fleet/names";
import { isCovered } from "../fleet/robotChoice";
import { type Announcement, notify, playSound } from "./announce";
import { type Preferences, usePreferences } from "./preferences";

/** The tab that announces alerts holds it, so that several tabs make one sound. */
const LOCK = siteKey("dock-gateway-announcer");

/** The most robots that are named: a notification is narrow. */
const NAMES = 4;

/** Announces each alert that begins while it is there, as this browser is set to. */
export default function Announcer(): null {
  const chosen = usePreferences();
  const { desktop, sound } = chosen;
  const leads = useLeadership();
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
    const wanted = together(alerts.filter((alert) => isWanted(alert, chosen, naming)));
    const fresh = wanted.filter((each) => each.some(({ id }) => !before.has(id)));
    if (desktop) for (const each of fresh) notify(announcement(each, naming, (path) => void navigate(path)));
    if (sound && fresh.length > 0) void playSound(fresh.some(([{ severity }]) => severity === "critical"));
  }, [live, alerts, chosen, desktop, sound, naming, navigate, leads]);
  return null;
}

/** What is said of alerts that are shown as one: of a stop of several robots once, also if it comes in parts. */
function announcement(alerts: Together, naming: Naming, go: (path: string) => void): Announcement {
  const [{ id, title, severity }] = alerts;
  const robots = robotsOf(alerts, naming);
  return {
    tag: siteKey(id),
    title: robots.length === 0 ? title : `${naming.list(robots, NAMES)}: ${title}`,
    body: detailOf(alerts),
    critical: severity === "critical",
    onPress: () => go(robots.length === 1 ? robotPath(robots[0] ?? "") : "/"),
  };
}

/** Whether an alert is to be announced; one of the gateway itself concerns everybody. */
export function isWanted(alert: Alert, chosen: Preferences, naming: Naming): boolean {
  if (alert.acknowledged !== null || (alert.severity === "warning" && !chosen.warnings)) return false;
  return alert.robot === null || isCovered(chosen.robots, alert.robot, naming.groupsOf(alert.robot));
}

/** Whether this tab is the one that announces; without locks, which need HTTPS, each tab is. */
function useLeadership() {
  const leads = useRef(false);
  useEffect(() => {
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
  }, []);
  return leads;
}
