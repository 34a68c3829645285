import type { StopNotice } from "../../api/places";
import type { SiteStops } from "./requests";

/** What each site of a hub has answered to a stop. */
export function noticeOf(sites: SiteStops): StopNotice {
  const names = Object.keys(sites);
  const missed = names.filter((name) => sites[name]?.stopped === false);
  const reached = names.filter((name) => !missed.includes(name));
  const warnings = names.flatMap((name) => sites[name]?.warning ?? []);
  const confirmed = reached.length === 0 ? "" : `Stopped: ${reached.join(", ")}. `;
  const warned = warnings.length === 0 ? "" : ` Warning: ${warnings.join("; ")}.`;
  if (missed.length > 0) {
    const repeated = missed.every((name) => sites[name]?.repeated);
    const why = missed.map((name) => sites[name]?.detail ?? name).join("; ");
    return {
      color: "red",
      title: `Stop has NOT reached ${reached.length === 0 ? "any site" : missed.join(", ")}`,
      message: `${confirmed}Not reached: ${why}. ${repeated ? "The hub repeats it until it arrives or is released. " : ""}Use the robots' own emergency stops if they move.${warned}`,
      autoClose: false,
    };
  }
  return {
    color: warnings.length > 0 ? "orange" : "green",
    title: "Stopped",
    message: `${confirmed}Each site has confirmed it.${warned}`,
    autoClose: warnings.length > 0 ? false : 8000,
  };
}
