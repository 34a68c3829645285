import type { Webhook, WebhookBody } from "../api/webhooks";
import { ALL_ROBOTS, choiceBody, choiceError, type RobotChoice } from "../fleet/robotChoice";

export const MAX_NAME = 60;
export const MAX_URL = 2000;

/** A webhook as it is typed. */
export interface Draft extends RobotChoice {
  name: string;
  url: string;
  warnings: boolean;
}

export function draftOf(webhook: Webhook | null): Draft {
  return {
    ...(webhook?.robots ?? ALL_ROBOTS),
    name: webhook?.name ?? "",
    url: webhook?.url ?? "",
    warnings: webhook?.severities.includes("warning") ?? true,
  };
}

export type DraftErrors = Partial<Record<"name" | "url" | "robots", string>>;

/** What is wrong with each field. */
export function errorsOf(draft: Draft): DraftErrors {
  const errors: DraftErrors = {};
  if (draft.name.trim() === "") errors.name = "Type a name.";
  const url = read(draft.url.trim());
  if (url === null || !["http:", "https:"].includes(url.protocol))
    errors.url = "An address that begins with https:// or http://";
  else if (url.username !== "" || url.password !== "") errors.url = "Leave out user name and password.";
  const wrong = choiceError(draft);
  if (wrong !== undefined) errors.robots = wrong;
  return errors;
}

function read(address: string): URL | null {
  try {
    return new URL(address);
  } catch {
    return null;
  }
}

/** The request that stores a webhook. */
export function bodyOf(draft: Draft, enabled: boolean, by: string | null): WebhookBody {
  return {
    name: draft.name.trim(),
    url: draft.url.trim(),
    enabled,
    severities: draft.warnings ? ["critical", "warning"] : ["critical"],
    robots: choiceBody(draft),
    by,
  };
}

/** The request that stores a webhook as it is, on or off. */
export function switched(
  { name, url, severities, robots }: Webhook,
  enabled: boolean,
  by: string | null,
): WebhookBody {
  return { name, url, enabled, severities, robots: choiceBody(robots), by };
}
