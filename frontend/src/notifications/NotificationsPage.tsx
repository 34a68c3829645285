import { Button, Group, SegmentedControl, Stack, Switch, Text } from "@mantine/core";
import { useState } from "react";
import { Parts } from "../extension/context";
import { RobotFields } from "../fleet/RobotFields";
import { choiceError } from "../fleet/robotChoice";
import { PageTitle, Section } from "../ui/Section";
import { allowNotifications, notify, playSound, whyNoNotifications } from "./announce";
import { setPreferences, usePreferences } from "./preferences";
import { SEVERITY_OPTIONS } from "./severities";

/** Who receives alerts, and how. */
export default function NotificationsPage() {
  return (
    <Stack gap="md">
      <PageTitle title="Notifications" help="dashboard#notifications-in-this-browser" />
      <ThisBrowser />
      <Parts at="notifications" />
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
