import { ClientError } from "@dock-gateway/client";
import { Button, Group, Skeleton, Stack, Text, TextInput, Title } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { type FormEvent, useCallback, useMemo, useState } from "react";
import { type FormContextValue, FormProvider } from "../actions/fields/context";
import { MessageFields } from "../actions/fields/MessageFields";
import { newDraft, outgoing, spaced, withField } from "../actions/form/draft";
import { type Path, shapeOf, type Value } from "../actions/form/shapes";
import { type NodeParameters as Answer, type ParameterInfo, parametersPath } from "../api/calls";
import { useForbidden } from "../api/session";
import { useWhyNot } from "../fleet/context";
import { Command } from "../ui/CopyButton";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useAnswer, useCommand } from "../ui/requests";
import { sentence } from "../ui/text";
import { postLine, useCallsApi } from "./calls";
import classes from "./graph.module.css";
import { changesOf, describe, isSettable, parametersSchema, valueText } from "./parameters";

/** More at once are found by their name: nav2's nodes have hundreds. */
const MOST = 30;

/** The parameters of a node, once somebody asks for them: the node has to answer. */
export function NodeParameters({ node }: { node: string }) {
  const [asked, setAsked] = useState(false);
  return (
    <Stack gap="xs" component="section" aria-label="Parameters">
      <Title order={3} size="h5">
        Parameters
      </Title>
      {asked ? (
        <Read node={node} />
      ) : (
        <Group>
          <Button variant="default" size="compact-sm" onClick={() => setAsked(true)}>
            Read the parameters
          </Button>
        </Group>
      )}
    </Stack>
  );
}

function Read({ node }: { node: string }) {
  const api = useCallsApi();
  const { data, error, refetch } = useAnswer({
    queryKey: ["parameters", node],
    queryFn: () => api.parameters(node),
    staleTime: 0,
    refetchOnWindowFocus: false,
  });
  const [search, setSearch] = useState("");
  const forbidden = useForbidden("PATCH /nodes/{node}/parameters");
  const reason = forbidden ?? (data?.set.reason ? `${sentence(data.set.reason)}.` : null);
  const { found, settable, fixed } = useMemo(
    () => sorted(data?.parameters ?? [], search, reason === null),
    [data, search, reason],
  );
  if (data === undefined) {
    if (error === null) return <Skeleton height={80} role="status" aria-busy="true" aria-label="Loading" />;
    return (
      <CommandErrorAlert command="Reading the parameters" error={error} onClose={() => void refetch()} />
    );
  }
  return (
    <>
      <Group gap="xs" wrap="nowrap">
        {data.parameters.length > 5 && (
          <TextInput
            flex={1}
            aria-label="Find a parameter"
            placeholder={`Find one of ${data.parameters.length}`}
            value={search}
            onChange={(event) => setSearch(event.currentTarget.value)}
          />
        )}
        <Button variant="default" size="compact-sm" onClick={() => void refetch()}>
          Read again
        </Button>
      </Group>
      {reason !== null && (
        <Text size="sm" c="dimmed">
          {reason}
        </Text>
      )}
      {settable.length > 0 && (
        <ParameterForm
          key={settable.map(({ name }) => name).join("\n")}
          answer={data}
          parameters={settable}
        />
      )}
      {fixed.length > 0 && <Fixed parameters={fixed} />}
      {found === 0 && <Text size="sm">No parameter has this name.</Text>}
      {found > MOST && (
        <Text size="sm" c="dimmed">
          {found - MOST} more: find them by their name.
        </Text>
      )}
    </>
  );
}

/** The number of parameters with such a name, and the first of them: those that a form sets, and those to read. */
function sorted(parameters: readonly ParameterInfo[], search: string, allowed: boolean) {
  const wanted = search.trim().toLowerCase();
  const found = parameters.filter(({ name }) => name.toLowerCase().includes(wanted));
  const shown = found.slice(0, MOST);
  const settable = shown.filter((parameter) => allowed && isSettable(parameter));
  return { found: found.length, settable, fixed: shown.filter((parameter) => !settable.includes(parameter)) };
}

/** Parameters to read. */
function Fixed({ parameters }: { parameters: readonly ParameterInfo[] }) {
  return (
    <ul className={classes.names}>
      {parameters.map((parameter) => (
        <li key={parameter.name}>
          <Text size="sm" fw={600} className={classes.wrap}>
            {parameter.name}
          </Text>
          <Text size="sm" className={classes.wrap}>
            {valueText(parameter.value)}
          </Text>
          <Text size="xs" c="dimmed" className={classes.lines}>
            {parameter.read_only ? "read-only, " : ""}
            {describe(parameter)}
          </Text>
        </li>
      ))}
    </ul>
  );
}

interface ParameterFormProps {
  answer: Answer;
  parameters: readonly ParameterInfo[];
}

/** Parameters to set: those that somebody changed, all of them or none. */
function ParameterForm({ answer: { node }, parameters }: ParameterFormProps) {
  const api = useCallsApi();
  const client = useQueryClient();
  const shape = useMemo(() => shapeOf(parametersSchema(parameters)), [parameters]);
  const [known, setKnown] = useState(parameters);
  const [draft, setDraft] = useState(() => newDraft(shape));
  if (known !== parameters) {
    // The node was asked again, and has other values: they are what is changed.
    setKnown(parameters);
    setDraft(newDraft(shape));
  }
  const [sought, setSought] = useState<string | null>(null);
  const { message, errors } = useMemo(() => outgoing(draft, shape), [draft, shape]);
  const changes = useMemo(() => changesOf(parameters, message ?? {}), [parameters, message]);
  const count = Object.keys(changes).length;
  const whyNot = useWhyNot("PATCH /nodes/{node}/parameters");

  const send = useCommand(async (body: string) => {
    try {
      const result = await api.setParameters(node, body);
      await client.invalidateQueries({ queryKey: ["parameters", node] });
      return result;
    } catch (error) {
      if (error instanceof ClientError && error.fields.length > 0) {
        const refused = error.fields.map(({ path, expected, detail }) => ({
          path,
          detail: `expected ${expected}, ${detail}`,
        }));
        setDraft((before) => ({ ...before, refused }));
      }
      throw error;
    }
  });
  const reason = whyNot ?? (count === 0 ? "Nothing is changed yet." : null);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (reason !== null || send.isPending) return;
    const wrong = errors.filter(({ path }) => !draft.refused.some((refused) => refused.path === path));
    if (wrong.length > 0) setSought(wrong[0]?.path ?? "");
    else send.mutate(spaced(changes));
  };
  const change = useCallback(
    (path: Path, value: Value) => setDraft((before) => withField(before, path, value)),
    [],
  );
  const found = useCallback(() => setSought(null), []);
  const form: FormContextValue = useMemo(
    () => ({ errors, change, sought, found }),
    [errors, change, sought, found],
  );
  return (
    <form noValidate onSubmit={submit}>
      <Stack gap="sm">
        <FormProvider value={form}>
          <MessageFields shape={shape} values={draft.values} path={[]} message={message ?? undefined} />
        </FormProvider>
        <Group gap="sm">
          <ReasonButton type="submit" reason={reason} loading={send.isPending}>
            {count > 1 ? `Set ${count} parameters` : "Set the parameter"}
          </ReasonButton>
          <Button variant="default" onClick={() => setDraft(newDraft(shape))} disabled={count === 0}>
            Reset
          </Button>
        </Group>
        <CommandErrorAlert command="Setting parameters" error={send.error} onClose={send.reset} />
        {send.data !== undefined && (
          <Text size="sm" role="status">
            Set: {send.data.map(({ name }) => name).join(", ")}.
          </Text>
        )}
        {count > 0 && (
          <Command
            line={postLine("PATCH", parametersPath(node), spaced(changes))}
            what="the command that does the same"
          />
        )}
      </Stack>
    </form>
  );
}
