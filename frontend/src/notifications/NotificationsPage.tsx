import { Button, Code, Group, SegmentedControl, Skeleton, Stack, Switch, Text } from "@mantine/core";
import { useState } from "react";
import { useForbidden } from "../api/session";
import type { StoredWebhook, Webhook } from "../api/webhooks";
import { useWhyNot } from "../fleet/context";
import { RobotFields } from "../fleet/RobotFields";
import { choiceError } from "../fleet/robotChoice";
import { CopyButton } from "../ui/CopyButton";
import { Dialog } from "../ui/Dialog";
import { Empty } from "../ui/Empty";
import { Trouble } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { PageTitle, Section } from "../ui/Section";
import {
  allowNotifications,
  notify,
  playSound,
  setPreferences,
  usePreferences,
  whyNoNotifications,
} from "./announce";
import { SEVERITY_OPTIONS, useWebhooks } from "./useWebhooks";
import { WebhookCard } from "./WebhookCard";
import { type Draft, EXAMPLE, WebhookForm } from "./WebhookForm";

/** Who receives alerts, and how. */
export default function NotificationsPage() {
  return (
    <Stack gap="md">
      <PageTitle title="Notifications" />
      <ThisBrowser />
      <Webhooks />
    </Stack>
  );
}

/** How this browser announces alerts while the dashboard is open. */
function ThisBrowser() {
  const { desktop, sound, warnings, robots } = usePreferences();
  const [refused, setRefused] = useState(false);
  const blocked = whyNoNotifications();
  const switchDesktop = async (on: boolean) => {
    const allowed = on && (await allowNotifications());
    setRefused(on && !allowed);
    setPreferences({ desktop: allowed });
  };
  const switchSound = (on: boolean) => {
    setPreferences({ sound: on });
    if (on) void playSound(false);
  };
  const tryOut = () => {
    if (sound) void playSound(true);
    if (desktop)
      notify({
        tag: "test",
        title: "Test",
        body: "This is how alerts are announced.",
        critical: false,
        onPress: () => {},
      });
  };
  return (
    <Section title="This browser">
      <Stack gap="sm">
        <Text size="sm" c="dimmed" maw="44rem">
          Announces alerts that begin while the dashboard is open, in any tab. Kept in this browser.
        </Text>
        <Switch
          label="Notifications on this computer"
          description={blocked ?? (refused ? "The browser did not allow notifications." : undefined)}
          checked={desktop && blocked === null}
          disabled={blocked !== null}
          onChange={({ currentTarget: { checked } }) => void switchDesktop(checked)}
        />
        <Switch
          label="Sound"
          description="Two notes for a critical alert, one for a warning. After the page was loaded, press anything on it once: browsers are silent until then."
          checked={sound}
          onChange={({ currentTarget: { checked } }) => switchSound(checked)}
        />
        {(desktop || sound) && (
          <Stack gap="sm" maw="32rem">
            <SegmentedControl
              aria-label="Alerts"
              data={SEVERITY_OPTIONS}
              value={warnings ? "all" : "critical"}
              onChange={(value) => setPreferences({ warnings: value === "all" })}
            />
            <RobotFields
              chosen={robots}
              error={choiceError(robots)}
              onChange={(part) => setPreferences({ robots: { ...robots, ...part } })}
            />
            <Group>
              <Button variant="default" size="compact-sm" onClick={tryOut}>
                Try it
              </Button>
            </Group>
          </Stack>
        )}
      </Stack>
    </Section>
  );
}

/** The webhook in the dialog; null for a new one, which may start from an example. */
type Edited = { webhook: Webhook | null; example?: Partial<Draft> };

/** The addresses that receive alerts. */
function Webhooks() {
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
