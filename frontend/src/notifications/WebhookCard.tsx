import { Alert, Switch } from "@mantine/core";
import { ownName } from "../access/who";
import type { Webhook } from "../api/webhooks";
import { useNaming, useWhyNot } from "../fleet/context";
import { robotsWords } from "../fleet/robotChoice";
import { ENTRY_BUTTON, EntryCard } from "../ui/EntryCard";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { Deliveries } from "./Deliveries";
import { switched } from "./draft";
import { useWebhookCommands } from "./useWebhooks";
import { severityWords, testWords } from "./words";

/** A webhook: which alerts it receives, a test, and what was sent to it. */
export function WebhookCard({ webhook, onEdit }: { webhook: Webhook; onEdit: () => void }) {
  const naming = useNaming();
  const { save, remove, test } = useWebhookCommands();
  const reason = useWhyNot("GET /webhooks");
  return (
    <EntryCard
      entry={webhook}
      words={[webhook.url, `${severityWords(webhook)}. ${robotsWords(webhook.robots, naming)}`]}
      control={
        <Switch
          label="On"
          aria-label={`${webhook.name} is on`}
          checked={webhook.enabled}
          disabled={reason !== null || save.isPending}
          onChange={({ currentTarget: { checked } }) =>
            save.mutate({ id: webhook.id, body: switched(webhook, checked, ownName().trim() || null) })
          }
        />
      }
      buttons={
        <ReasonButton
          {...ENTRY_BUTTON}
          reason={reason}
          aria-label={`Test ${webhook.name}`}
          loading={test.isPending}
          onClick={() => test.mutate(webhook.id)}
        >
          Test
        </ReasonButton>
      }
      reason={reason}
      onEdit={onEdit}
      remove={remove}
      removal="Its secret and the list of what was sent to it are deleted."
    >
      <div role="status">
        {test.data !== undefined && (
          <Alert
            color={test.data.state === "delivered" ? "green" : "red"}
            title={test.data.state === "delivered" ? "Test delivered" : "Test not delivered"}
            withCloseButton
            closeButtonLabel="Dismiss"
            onClose={test.reset}
          >
            {testWords(test.data)}
          </Alert>
        )}
      </div>
      <CommandErrorAlert command="The test" error={test.error} onClose={test.reset} />
      <CommandErrorAlert command="Saving" error={save.error} onClose={save.reset} />
      <Deliveries webhook={webhook} />
    </EntryCard>
  );
}
