import { SegmentedControl, TextInput } from "@mantine/core";
import { LIMITS } from "../../api/limits.gen";
import { EntryForm } from "../../entries/EntryForm";
import { RobotFields } from "../../fleet/RobotFields";
import { ALL_ROBOTS, choiceBody, choiceError, type RobotChoice } from "../../fleet/robotChoice";
import { SEVERITY_OPTIONS } from "../../notifications/severities";
import type { StoredWebhook, Webhook, WebhookBody } from "./requests";
import { useWebhookCommands } from "./useWebhooks";

interface WebhookFormProps {
  /** Null for a new one. */
  webhook: Webhook | null;
  /** What a new one starts from. */
  example?: Partial<Draft> | undefined;
  /** All webhooks, as they are now. */
  webhooks: readonly Webhook[];
  /** Null where nothing was stored. */
  onDone: (stored: StoredWebhook | null) => void;
}

/** Adds a webhook, or changes one. */
export function WebhookForm({ webhook, example, webhooks, onDone }: WebhookFormProps) {
  const { save } = useWebhookCommands();
  return (
    <EntryForm
      noun="webhook"
      entry={webhook}
      draftOf={draftOf}
      example={example}
      entries={webhooks}
      placeholder="Control room"
      maxName={NAME.maxLength}
      errorsOf={errorsOf}
      bodyOf={(draft, by, replaced) => bodyOf(draft, replaced?.enabled ?? true, by)}
      save={save}
      onSaved={onDone}
      onCancel={() => onDone(null)}
    >
      {(draft, errors, change) => (
        <>
          <TextInput
            label="Address"
            type="url"
            placeholder="https://hooks.example.com/robots"
            maxLength={URL_FIELD.maxLength}
            value={draft.url}
            error={errors.url}
            onChange={(event) => change({ url: event.currentTarget.value })}
          />
          <SegmentedControl
            aria-label="Alerts"
            data={SEVERITY_OPTIONS}
            value={draft.warnings ? "all" : "critical"}
            onChange={(value) => change({ warnings: value === "all" })}
          />
          <RobotFields chosen={draft} error={errors.robots} onChange={change} />
        </>
      )}
    </EntryForm>
  );
}

const { name: NAME, url: URL_FIELD } = LIMITS["PUT /webhooks/{webhook_id}"];

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

/** A webhook to start from: the receiver of the documents. */
export const EXAMPLE: Partial<Draft> = { name: "Receiver", url: "http://127.0.0.1:9000", warnings: true };

type DraftErrors = Partial<Record<"name" | "url" | "robots", string>>;

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
