import { Badge, Group, Skeleton, Table, Text } from "@mantine/core";
import { useState } from "react";
import type { Delivery, Webhook } from "../api/webhooks";
import { useNaming } from "../fleet/context";
import { Trouble } from "../ui/errors";
import { Time } from "../ui/Time";
import { useZone } from "../ui/zone";
import classes from "./notifications.module.css";
import { useDeliveries } from "./useWebhooks";
import { alertWords, EVENTS, outcomeWords, STATES } from "./words";

/** The last delivery in a line, which unfolds to all of them. */
export function Deliveries({ webhook }: { webhook: Webhook }) {
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
            <Time value={last.tried_at ?? last.at} />
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
        <Time value={delivery.at} />
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
