import { Code, Group, Stack, Text, Title } from "@mantine/core";
import { type FormEvent, type ReactNode, useCallback, useId, useMemo, useState } from "react";
import actionClasses from "../actions/actions.module.css";
import { DraftFields, ModeSwitch, refusedFields } from "../actions/DraftFields";
import { shapeOf } from "../actions/form/shapes";
import { useDraft } from "../actions/useDraft";
import type { Json, JsonSchema } from "../api/jsonSchema";
import { Command } from "../ui/CopyButton";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";

interface MessageFormProps<Answer> {
  /** What is done, as a title: "Call the service". */
  title: string;
  /** The key under which the draft is kept, one for each form. */
  draft: string;
  schema: JsonSchema;
  /** On the button. */
  verb: string;
  /** What it may do, asked before it is sent; null where it does nothing. */
  question: string | null;
  /** Why it cannot be sent now; null where it can. */
  reason: string | null;
  /** @param body The message as JSON. */
  send: (body: string) => Promise<Answer>;
  /** How it is sent from a terminal. */
  line: (body: string) => string;
  /** What came of it. */
  children: (answer: Answer) => ReactNode;
}

const NOTHING: Json = {};

/** A message to fill in, as a form or as JSON, and to send. */
export function MessageForm<Answer>(props: MessageFormProps<Answer>) {
  const { title, schema, verb, question, reason, line, children } = props;
  const shape = useMemo(() => shapeOf(schema), [schema]);
  const state = useDraft(props.draft, shape, NOTHING);
  const { body, ready, errors } = state;
  const [sought, setSought] = useState<string | null>(null);
  const [asking, setAsking] = useState(false);
  const titleId = useId();

  const send = useCommand(async (text: string) => {
    try {
      return await props.send(text);
    } catch (error) {
      const refused = refusedFields(error);
      if (refused.length > 0) state.refuse(refused);
      throw error;
    }
  });
  const whyNot = reason ?? (send.isPending ? "It was sent. There is no answer yet." : null);
  const begin = () => {
    setAsking(false);
    send.reset();
    state.refuse([]);
    if (body !== null) send.mutate(body);
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (whyNot !== null) return;
    if (!ready) setSought(errors[0]?.path ?? "");
    else if (question !== null) setAsking(true);
    else begin();
  };
  const found = useCallback(() => setSought(null), []);
  return (
    <Stack gap="sm" component="section" aria-labelledby={titleId}>
      <Group justify="space-between" gap="xs">
        <Title order={3} size="h5" id={titleId}>
          {title}
        </Title>
        {shape.fields.length > 0 && <ModeSwitch state={state} label="Write the message as" size="xs" />}
      </Group>
      <form noValidate onSubmit={submit}>
        <Stack gap="sm">
          <DraftFields state={state} shape={shape} sought={sought} onFound={found} label="Message as JSON" />
          <Group gap="sm">
            <ReasonButton type="submit" reason={whyNot} loading={send.isPending}>
              {question === null ? verb : `${verb} …`}
            </ReasonButton>
            {!ready && (
              <Text size="sm" c="dimmed" role="status">
                Fix {errors.length} invalid {errors.length === 1 ? "value" : "values"}.
              </Text>
            )}
          </Group>
        </Stack>
      </form>
      <CommandErrorAlert command={verb} error={send.error} onClose={send.reset} />
      {send.data !== undefined && <div role="status">{children(send.data)}</div>}
      {body !== null && <Command line={line(body)} what="the command that does the same" />}
      <Dialog opened={asking} onClose={() => setAsking(false)} title={`${verb}?`}>
        <Stack gap="md">
          <Text size="sm">{question}</Text>
          <Code block className={actionClasses.body} tabIndex={0} role="region" aria-label="What is sent">
            {body}
          </Code>
          <QuestionBar
            keep="Not now"
            onKeep={() => setAsking(false)}
            go={verb}
            onGo={begin}
            reason={whyNot}
          />
        </Stack>
      </Dialog>
    </Stack>
  );
}
