import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

export type RobotLabel = components["schemas"]["Label"];

/** Replaces the display name and the groups of a robot; throws a CommandError where it fails. */
export function putLabel(http: Http, label: RobotLabel): Promise<RobotLabel> {
  return settle(http.PUT("/robots/label", { body: label, signal: deadline() }));
}
