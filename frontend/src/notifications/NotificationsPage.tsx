import { Stack } from "@mantine/core";
import { PageTitle } from "../ui/PageTitle";
import { ThisBrowser } from "./ThisBrowser";
import { Webhooks } from "./Webhooks";

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
