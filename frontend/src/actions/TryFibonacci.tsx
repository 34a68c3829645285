import { Stack, Text } from "@mantine/core";
import { Command } from "../ui/Command";
import { Section } from "../ui/Section";
import { sendLine } from "./curl";

/** The next step where there is no action to try. */
export function TryFibonacci() {
  const { origin } = window.location;
  return (
    <Section title="An action to try">
      <Text size="sm">
        Fibonacci counts, a number a second, and moves nothing. Start its action server in a terminal, with
        the environment of dock-gateway active: it appears on this page within seconds.
      </Text>
      <Stack gap="xs">
        <Command line="fibonacci_action_server" what="the command that starts the Fibonacci action server" />
        <Text size="sm">Then send it a goal from here, or with</Text>
        <Command
          line={sendLine(origin, "/fibonacci", '{"order": 10}')}
          what="the command that sends a Fibonacci goal"
        />
        <Text size="sm">Every other action on the graph appears here, too; the same list in a terminal:</Text>
        <Command line={`curl -s ${origin}/actions`} what="the command that lists the actions" />
      </Stack>
    </Section>
  );
}
