import { Code, Stack, Text } from "@mantine/core";
import { Command } from "../../ui/CopyButton";
import { Section } from "../../ui/Section";

const KEY = "dock-gateway hub key > hub-key.json";
const SERVE =
  "dock-gateway serve --nats tls://nats.example.com:4222 --site berlin --hub-public-keys hub-key.json --nats-credentials berlin.creds";

/** How the first site is connected. */
export function NoSites() {
  return (
    <Section title="No site yet" help="extensions/sites#connect-a-site">
      <Text size="sm">
        A site appears here by itself, as soon as its gateway is connected. A gateway connects to the same
        NATS servers as this hub; nothing has to reach the site from outside.
      </Text>
      <Stack gap="sm">
        <div>
          <Text size="sm" mb={2}>
            Here, at the hub: write its public key into a file, and copy that to the site
          </Text>
          <Command line={KEY} what="the command that prints the hub's public key" />
        </div>
        <div>
          <Text size="sm" mb={2}>
            At the site: start the gateway with a name of its own
          </Text>
          <Command line={SERVE} what="the command that connects a site" />
        </div>
      </Stack>
      <Text size="sm" c="dimmed">
        What people may do there through the hub is set at the site, with <Code>--hub-role</Code> and{" "}
        <Code>--hub-robots</Code>.
      </Text>
    </Section>
  );
}
