import { Stack, Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";
import { ThisBrowser } from "./ThisBrowser";
import { Webhooks } from "./Webhooks";

/** Who receives alerts, and how. */
export default function NotificationsPage() {
  usePageTitle("Notifications");
  return (
    <Stack gap="md">
      <Title order={1} size="h3">
        Notifications
      </Title>
      <ThisBrowser />
      <Webhooks />
    </Stack>
  );
}
