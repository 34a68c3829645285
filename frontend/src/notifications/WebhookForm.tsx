import { SegmentedControl, Stack, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { NameInput } from "../access/NameInput";
import { ownName, setOwnName } from "../access/who";
import type { StoredWebhook, Webhook } from "../api/webhooks";
import { RobotFields } from "../fleet/RobotFields";
import { SaveBar } from "../ui/Dialog";
import { newId } from "../ui/text";
import { bodyOf, type Draft, draftOf, errorsOf, MAX_NAME, MAX_URL } from "./draft";
import { useWebhookCommands } from "./useWebhooks";
import { SEVERITY_OPTIONS } from "./words";

interface WebhookFormProps {
  /** Null for a new one. */
  webhook: Webhook | null;
  /** All of them. */
  webhooks: readonly Webhook[];
  /** Null where nothing was stored. */
  onDone: (stored: StoredWebhook | null) => void;
}

/** Adds a webhook, or changes one. */
export function WebhookForm({ webhook, webhooks, onDone }: WebhookFormProps) {
  const [draft, setDraft] = useState(() => draftOf(webhook));
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const { save } = useWebhookCommands();
  const errors = errorsOf(draft);
  const shown = tried ? errors : {};
  const change = (part: Partial<Draft>) => setDraft((before) => ({ ...before, ...part }));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (Object.keys(errors).length > 0) return;
    setOwnName(by.trim());
    const taken = webhooks.map(({ id }) => id);
    const id = webhook?.id ?? newId(draft.name, taken, "webhook");
    const body = bodyOf(draft, webhook?.enabled ?? true, by.trim() || null);
    save.mutate({ id, body }, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TextInput
          label="Name"
          placeholder="Control room"
          maxLength={MAX_NAME}
          value={draft.name}
          error={shown.name}
          onChange={(event) => change({ name: event.currentTarget.value })}
          data-autofocus
        />
        <TextInput
          label="Address"
          type="url"
          placeholder="https://hooks.example.com/robots"
          maxLength={MAX_URL}
          value={draft.url}
          error={shown.url}
          onChange={(event) => change({ url: event.currentTarget.value })}
        />
        <SegmentedControl
          aria-label="Alerts"
          data={SEVERITY_OPTIONS}
          value={draft.warnings ? "all" : "critical"}
          onChange={(value) => change({ warnings: value === "all" })}
        />
        <RobotFields chosen={draft} error={shown.robots} onChange={change} />
        <NameInput value={by} description="Shown with the webhook." onChange={setBy} />
        <SaveBar save={save} onCancel={() => onDone(null)} />
      </Stack>
    </form>
  );
}
