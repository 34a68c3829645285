import { Code, Paper, Stack, Text } from "@mantine/core";
import { Command } from "../ui/Command";

/** What to do where there is nothing to show. */
export function EmptyGraph({ filtered }: { filtered: boolean }) {
  return (
    <Paper withBorder radius="md" p="lg">
      <Stack gap="sm">
        <Text fw={600}>Nothing to show</Text>
        <Text size="sm" c="dimmed">
          {filtered
            ? "Nothing on the graph is in this namespace. Choose another one above."
            : "The gateway is alone on the ROS graph, as far as it sees. Nodes show up here within seconds of their start, if they have the same ROS_DOMAIN_ID."}
        </Text>
        <Text size="sm">
          A simulated robot: <Code>dock-gateway up</Code>. The same as this page, in a terminal:
        </Text>
        <Command line={`curl ${window.location.origin}/graph`} what="the command that reads the graph" />
      </Stack>
    </Paper>
  );
}
