import { Code, Group, Skeleton, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useForbidden } from "../../api/session";
import { useWhyNot } from "../../fleet/context";
import { CopyButton } from "../../ui/CopyButton";
import { Dialog } from "../../ui/Dialog";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { Section } from "../../ui/Section";
import type { StoredWebhook, Webhook } from "./requests";
import { useWebhooks } from "./useWebhooks";
import { WebhookCard } from "./WebhookCard";
import { type Draft, EXAMPLE, WebhookForm } from "./WebhookForm";

/** The webhook in the dialog; null for a new one, which may start from an example. */
type Edited = { webhook: Webhook | null; example?: Partial<Draft> };

/** The addresses that receive alerts. */
export default function Webhooks() {
  const forbidden = useForbidden("GET /webhooks");
  const { data: webhooks, error, refetch } = useWebhooks();
  const reason = useWhyNot("GET /webhooks", webhooks !== undefined);
  const [edited, setEdited] = useState<Edited | null>(null);
  const [secret, setSecret] = useState<string | null>(null);
  const done = (stored: StoredWebhook | null) => {
    setEdited(null);
    if (stored !== null) setSecret(stored.secret);
  };
  return (
    <Section
      title="Webhooks"
      help="extensions/webhooks#set-one-up"
      aside={
        <ReasonButton size="compact-md" reason={reason} onClick={() => setEdited({ webhook: null })}>
          New webhook
        </ReasonButton>
      }
    >
      <Trouble what="The webhooks could not be loaded" error={error} onRetry={() => void refetch()} />
      {forbidden !== null && webhooks === undefined ? (
        <Text size="sm" c="dimmed" maw="44rem">
          The addresses of webhooks are often secret. {forbidden}
        </Text>
      ) : webhooks === undefined ? (
        error === null && <Skeleton height={90} role="status" aria-label="The webhooks are loading" />
      ) : webhooks.length === 0 ? (
        <Empty
          inside
          title="No webhooks"
          examples={
            <ReasonButton
              variant="default"
              reason={reason}
              onClick={() => setEdited({ webhook: null, example: EXAMPLE })}
            >
              Example: all alerts to a receiver on the gateway's machine
            </ReasonButton>
          }
        >
          A webhook tells another system of every alert that begins or ends: a chat, a pager, or a script of
          yours.
        </Empty>
      ) : (
        <Stack component="ul" gap="sm" m={0} p={0} aria-label="Webhooks">
          {webhooks.map((webhook) => (
            <WebhookCard key={webhook.id} webhook={webhook} onEdit={() => setEdited({ webhook })} />
          ))}
        </Stack>
      )}
      <Dialog
        opened={edited !== null}
        onClose={() => done(null)}
        title={edited?.webhook ? `Edit ${edited.webhook.name}` : "New webhook"}
      >
        {edited !== null && (
          <WebhookForm
            webhook={edited.webhook}
            example={edited.example}
            webhooks={webhooks ?? []}
            onDone={done}
          />
        )}
      </Dialog>
      <Dialog opened={secret !== null} onClose={() => setSecret(null)} title="The webhook's secret">
        {secret !== null && <Secret secret={secret} />}
      </Dialog>
    </Section>
  );
}

function Secret({ secret }: { secret: string }) {
  return (
    <Stack gap="md">
      <Text size="sm">
        With it the receiver checks that a request comes from this gateway. Copy it now: it is not shown
        again.
      </Text>
      <Group gap="sm" wrap="nowrap" align="start">
        <Code block style={{ overflowWrap: "anywhere", whiteSpace: "pre-wrap" }}>
          {secret}
        </Code>
        <CopyButton value={secret} what="the secret" />
      </Group>
    </Stack>
  );
}
