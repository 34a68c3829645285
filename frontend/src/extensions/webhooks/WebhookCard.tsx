import { Alert, Badge, Group, Skeleton, Switch, Table, Text } from "@mantine/core";
import { useState } from "react";
import { ownName } from "../../access/who";
import { EntryCard } from "../../entries/EntryCard";
import { useNaming, useWhyNot } from "../../fleet/context";
import { robotsWords } from "../../fleet/robotChoice";
import { CommandErrorAlert, Trouble } from "../../ui/errors";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import { Time } from "../../ui/Time";
import { useZone } from "../../ui/zone";
import type { Delivery, Webhook } from "./requests";
import {
  alertWords,
  EVENTS,
  outcomeWords,
  STATES,
  severityWords,
  testWords,
  useDeliveries,
  useWebhookCommands,
} from "./useWebhooks";
import { switched } from "./WebhookForm";
import classes from "./webhooks.module.css";

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
            save.mutate({
              id: webhook.id,
              body: switched(webhook, checked, ownName().trim() || null),
              base: webhook,
            })
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

/** The last delivery in a line, which unfolds to all of them. */
function Deliveries({ webhook }: { webhook: Webhook }) {
  const [opened, setOpened] = useState(false);
  const { last_delivery: last, pending } = webhook;
  if (last === null && pending === 0)
    return (
      <Text size="sm" c="dimmed">
        Nothing sent yet
      </Text>
    );
  return (
    <details className={classes.deliveries} onToggle={(event) => setOpened(event.currentTarget.open)}>
      <summary>
        {last === null ? (
          "Not sent yet"
        ) : (
          <>
            Last {last.state === "delivered" ? "delivered" : "tried"}{" "}
            <Time value={last.tried_at ?? last.created_at} />
            {last.state !== "delivered" && `: ${last.error}`}
          </>
        )}
        {pending > 0 && `, ${pending} pending`}
      </summary>
      {opened && <List id={webhook.id} />}
    </details>
  );
}

function List({ id }: { id: string }) {
  const { data: deliveries, error, refetch } = useDeliveries(id);
  useZone();
  return (
    <>
      <Trouble what="The deliveries could not be loaded" error={error} onRetry={() => void refetch()} />
      {deliveries === undefined ? (
        error === null && <Skeleton height={60} mt="xs" />
      ) : (
        <Table verticalSpacing="xs" horizontalSpacing={8} mt="xs" aria-label="Deliveries">
          <Table.Thead>
            <Table.Tr>
              <Table.Th className={classes.time}>Time</Table.Th>
              <Table.Th>Alert</Table.Th>
              <Table.Th>Result</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {deliveries.map((delivery) => (
              <Row key={delivery.id} delivery={delivery} />
            ))}
          </Table.Tbody>
        </Table>
      )}
    </>
  );
}

function Row({ delivery }: { delivery: Delivery }) {
  const { words, color } = STATES[delivery.state];
  const naming = useNaming();
  return (
    <Table.Tr>
      <Table.Td className={`tabular ${classes.time}`}>
        <Time value={delivery.created_at} />
      </Table.Td>
      <Table.Td className={classes.words}>
        <Text size="sm">{alertWords(delivery, naming)}</Text>
        <Text size="xs" c="dimmed">
          {EVENTS[delivery.type]}
        </Text>
      </Table.Td>
      <Table.Td>
        <Group gap="xs">
          <Badge variant="outline" color={color}>
            {words}
          </Badge>
          <Text size="sm">{outcomeWords(delivery)}</Text>
        </Group>
      </Table.Td>
    </Table.Tr>
  );
}
