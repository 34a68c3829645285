import { Alert, Button, Group, Paper, Stack, Switch, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useId } from "react";
import type { Webhook } from "../api/webhooks";
import { useFleetLive } from "../fleet/context";
import { robotsWords } from "../fleet/robotChoice";
import { useNaming } from "../fleet/useNaming";
import { ownName } from "../stop/who";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import { Deliveries } from "./Deliveries";
import { switched } from "./draft";
import classes from "./notifications.module.css";
import { useWebhookCommands } from "./useWebhooks";
import { severityWords, testWords } from "./words";

/** A webhook: which alerts it receives, a test, and what was sent to it. */
export function WebhookCard({ webhook, onEdit }: { webhook: Webhook; onEdit: () => void }) {
  const naming = useNaming();
  const live = useFleetLive();
  const { save, remove, test } = useWebhookCommands();
  const [removing, removal] = useDisclosure(false);
  const titleId = useId();
  const away = live ? null : "The gateway is not connected.";
  const button = { variant: "default", size: "compact-sm", reason: away };
  return (
    <Paper component="li" withBorder radius="md" p="md" className={classes.webhook} aria-labelledby={titleId}>
      <div className={classes.head}>
        <Stack gap={2} className={classes.words}>
          <Text fw={600} id={titleId}>
            {webhook.name}
          </Text>
          <Text size="sm">{webhook.url}</Text>
          <Text size="sm">
            {severityWords(webhook)}. {robotsWords(webhook.robots, naming)}
          </Text>
          <Text size="sm" c="dimmed">
            Changed {webhook.changed_by !== null && `by ${webhook.changed_by}, `}
            <Time value={webhook.changed_at} />
          </Text>
        </Stack>
        <Stack gap="xs" className={classes.commands}>
          <Switch
            label="On"
            aria-label={`${webhook.name} is on`}
            checked={webhook.enabled}
            disabled={!live || save.isPending}
            onChange={({ currentTarget: { checked } }) =>
              save.mutate({ id: webhook.id, body: switched(webhook, checked, ownName().trim() || null) })
            }
          />
          <Group gap="xs">
            <ReasonButton
              {...button}
              aria-label={`Test ${webhook.name}`}
              loading={test.isPending}
              onClick={() => test.mutate(webhook.id)}
            >
              Test
            </ReasonButton>
            <ReasonButton {...button} aria-label={`Edit ${webhook.name}`} onClick={onEdit}>
              Edit
            </ReasonButton>
            <ReasonButton {...button} aria-label={`Remove ${webhook.name}`} onClick={removal.open}>
              Remove
            </ReasonButton>
          </Group>
        </Stack>
      </div>
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
      <Dialog opened={removing} onClose={removal.close} title={`Remove ${webhook.name}?`}>
        <Stack gap="md">
          <Text size="sm">Its secret and the list of what was sent to it are deleted.</Text>
          <CommandErrorAlert command="Removing" error={remove.error} onClose={remove.reset} />
          <Group justify="flex-end" gap="sm">
            <Button variant="default" onClick={removal.close} data-autofocus>
              Keep it
            </Button>
            <Button color="red" loading={remove.isPending} onClick={() => remove.mutate(webhook.id)}>
              Remove
            </Button>
          </Group>
        </Stack>
      </Dialog>
    </Paper>
  );
}
