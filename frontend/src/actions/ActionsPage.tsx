import type { ActionInfo } from "@dock-gateway/client";
import { Group, Skeleton, Stack, Text, TextInput } from "@mantine/core";
import { useSearchParams } from "react-router";
import { apiAddress } from "../api/site";
import { Command } from "../ui/CopyButton";
import { CommandErrorAlert } from "../ui/errors";
import { PageTitle, Section } from "../ui/Section";
import { ActionsTable } from "./ActionsTable";
import { sendLine, useActions } from "./actions";

/** The search is shown from this many actions on. */
const MANY = 6;

/** Every action on the graph; `?q=` is what is searched for. */
export default function ActionsPage() {
  const [query, setQuery] = useSearchParams();
  const wanted = query.get("q") ?? "";
  const { data, error, refetch } = useActions();
  const shown = data?.filter((action) => matches(action, wanted));

  return (
    <Stack gap="md">
      <PageTitle title="Actions" help="api#send-a-goal" />
      <CommandErrorAlert command="Looking for actions" error={error} onClose={() => void refetch()} />
      <Section
        title="On the graph"
        aside={
          data !== undefined &&
          (data.length >= MANY || wanted !== "") && (
            <Group gap="sm">
              <TextInput
                aria-label="Search for a name or a type"
                placeholder="Search name or type"
                type="search"
                value={wanted}
                onChange={(event) => setQuery(searchFor(event.currentTarget.value), { replace: true })}
              />
              <Text size="sm" c="dimmed" role="status">
                {shown?.length} of {data.length}
              </Text>
            </Group>
          )
        }
      >
        {shown === undefined ? (
          <Skeletons />
        ) : shown.length === 0 ? (
          <Text size="sm" c="dimmed">
            {data?.length === 0 ? "There is no action on the graph." : `No action is like “${wanted}”.`}
          </Text>
        ) : (
          <ActionsTable actions={shown} />
        )}
      </Section>
      {data !== undefined && !data.some(isOther) && <TryFibonacci />}
    </Stack>
  );
}

function matches({ action_name, action_type }: ActionInfo, wanted: string): boolean {
  const text = `${action_name} ${action_type}`.toLowerCase();
  return wanted
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

function searchFor(text: string): Record<string, string> {
  return text === "" ? {} : { q: text };
}

/** An action that is there besides docking and undocking, which are listed always. */
function isOther({ available, verb }: ActionInfo): boolean {
  return available && verb === null;
}

function Skeletons() {
  return (
    <Stack gap="sm" role="status" aria-busy="true" aria-label="The actions are loading">
      <Skeleton height={36} />
      <Skeleton height={36} />
      <Skeleton height={36} />
    </Stack>
  );
}

/** The next step where there is no action to try. */
function TryFibonacci() {
  const address = apiAddress();
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
          line={sendLine(address, "/fibonacci", '{"order": 10}')}
          what="the command that sends a Fibonacci goal"
        />
        <Text size="sm">Every other action on the graph appears here, too; the same list in a terminal:</Text>
        <Command line={`curl -s ${address}/actions`} what="the command that lists the actions" />
      </Stack>
    </Section>
  );
}
