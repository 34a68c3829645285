import { Anchor, Button, Group, SegmentedControl, Stack, Text } from "@mantine/core";
import { type FormEvent, useCallback, useId, useMemo, useState } from "react";
import { Link } from "react-router";
import { CommandError } from "../api/errors";
import type { ActionInfo, AnyGoal } from "../api/types";
import { useFleetLive, useFleetTopic } from "../fleet/context";
import { heldStops } from "../stop/held";
import { Command } from "../ui/CopyButton";
import { CommandErrorAlert } from "../ui/errors";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { type FormContextValue, FormProvider } from "./fields/context";
import { MessageFields } from "./fields/MessageFields";
import type { Draft } from "./form/draft";
import type { MessageShape } from "./form/shapes";
import { JsonEditor } from "./JsonEditor";
import { SendDialog, useAsking } from "./SendDialog";
import { useActionsApi } from "./useActions";
import type { useDraft } from "./useDraft";
import { isHeld, sendLine, whyNotSend } from "./words";

interface GoalFormProps {
  action: ActionInfo;
  shape: MessageShape;
  /** The draft, so that a goal of the past can be filled in. */
  draft: ReturnType<typeof useDraft>;
  onSent: (goal: AnyGoal) => void;
}

/** A goal to fill in, as a form or as JSON, and to send. */
export function GoalForm({ action, shape, draft: state, onSent }: GoalFormProps) {
  const name = action.action_name;
  const { draft, body, message, ready, errors, hidden, change } = state;
  const api = useActionsApi();
  const live = useFleetLive();
  const stops = heldStops(useFleetTopic("stop"), useFleetTopic("robots"));
  const [sought, setSought] = useState<string | null>(null);
  const [asking, setAsking] = useState(false);
  const { asks, harmless, change: setAsks } = useAsking(name, action.action_type);

  const reasonId = useId();

  const send = useCommand(async (text: string) => {
    try {
      const goal = await api.send(name, text);
      onSent(goal);
      return goal;
    } catch (error) {
      if (error instanceof CommandError && error.fields.length > 0) {
        const refused = error.fields.map(({ path, expected, detail }) => ({
          path,
          detail: expected === undefined ? detail : `expected ${expected}, ${detail}`,
        }));
        state.refuse(refused);
        setSought(refused[0]?.path ?? null);
      }
      throw error;
    }
  });
  const reason = whyNotSend({ live, action, stopped: isHeld(name, stops), sending: send.isPending });

  const begin = () => {
    send.reset();
    state.refuse([]);
    if (body !== null) send.mutate(body);
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (reason !== null) return;
    if (!ready) setSought(errors[0]?.path ?? "");
    else if (asks) setAsking(true);
    else begin();
  };

  const found = useCallback(() => setSought(null), []);
  const form: FormContextValue = useMemo(
    () => ({ errors, change, sought, found }),
    [errors, change, sought, found],
  );
  return (
    <Section
      title="Goal"
      aside={
        <SegmentedControl
          aria-label="Write the goal as"
          value={draft.mode}
          onChange={(mode) => state.setMode(mode as Draft["mode"])}
          data={[
            { label: "Form", value: "form" },
            { label: "JSON", value: "json" },
          ]}
        />
      }
    >
      {shape.description !== null && <Text size="sm">{shape.description}</Text>}
      <form noValidate onSubmit={submit}>
        <Stack gap="md">
          <FormProvider value={form}>
            {draft.mode === "json" ? (
              <JsonEditor text={draft.text} onChange={state.setText} hidden={hidden} />
            ) : (
              <MessageFields shape={shape} values={draft.values} path={[]} message={message} />
            )}
          </FormProvider>
          <Group gap="sm">
            <Button
              type="submit"
              size="md"
              disabled={reason !== null}
              title={reason ?? undefined}
              aria-describedby={reasonId}
            >
              {asks ? "Send goal …" : "Send goal"}
            </Button>
            <Button variant="default" size="md" onClick={state.clear}>
              Reset
            </Button>
            {!asks && !harmless && (
              <Button variant="default" size="md" onClick={() => setAsks(true)}>
                Ask again before sending
              </Button>
            )}
          </Group>
          <Text size="sm" c="dimmed" id={reasonId} role="status" mih="1.5em">
            {reason ?? (ready ? <SentLine goal={send.data ?? null} /> : notSent(errors.length))}
          </Text>
        </Stack>
      </form>
      <CommandErrorAlert command="Send goal" error={send.error} onClose={send.reset} />
      {ready && body !== null ? (
        <div>
          <Text size="sm" mb={2}>
            The same from a terminal
          </Text>
          <Command
            line={sendLine(window.location.origin, name, body)}
            what="the command that sends this goal"
          />
        </div>
      ) : (
        <Text size="sm" c="dimmed">
          When the goal is valid, the command line that sends it stands here.
        </Text>
      )}
      <SendDialog
        action={name}
        body={body ?? ""}
        reason={reason}
        opened={asking}
        onClose={() => setAsking(false)}
        onSend={(never) => {
          if (never) setAsks(false);
          begin();
          setAsking(false);
        }}
      />
    </Section>
  );
}

function notSent(wrong: number): string {
  return `Fix ${wrong} invalid ${wrong === 1 ? "value" : "values"}.`;
}

/** What became of the goal that was sent from here. */
export function SentLine({ goal }: { goal: AnyGoal | null }) {
  if (goal === null) return null;
  return (
    <span data-testid="sent">
      Sent: the action server took{" "}
      <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} inherit>
        goal {goal.goal_id.slice(0, 8)}
      </Anchor>
      .
    </span>
  );
}
