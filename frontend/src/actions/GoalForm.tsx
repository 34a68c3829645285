import type { ActionInfo, LiveGoal } from "@dock-gateway/client";
import { Anchor, Button, Checkbox, Code, Group, Stack, Text } from "@mantine/core";
import { useLocalStorage } from "@mantine/hooks";
import { type FormEvent, useCallback, useId, useState } from "react";
import { Link } from "react-router";
import { apiAddress } from "../api/site";
import { useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { heldStops } from "../stop/held";
import { Command } from "../ui/CopyButton";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { isHeld, sendLine, useActionsApi, whyNotSend } from "./actions";
import classes from "./actions.module.css";
import { DraftFields, ModeSwitch, refusedFields } from "./DraftFields";
import type { MessageShape } from "./form/shapes";
import type { useDraft } from "./useDraft";

interface GoalFormProps {
  action: ActionInfo;
  shape: MessageShape;
  /** The draft, so that a goal of the past can be filled in. */
  draft: ReturnType<typeof useDraft>;
  onSent: (goal: LiveGoal) => void;
}

/** A goal to fill in, as a form or as JSON, and to send. */
export function GoalForm({ action, shape, draft: state, onSent }: GoalFormProps) {
  const name = action.action_name;
  const { body, ready, errors } = state;
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
      const refused = refusedFields(error);
      if (refused.length > 0) {
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
  return (
    <Section
      title="Goal"
      help="dashboard#goals-as-json"
      aside={<ModeSwitch state={state} label="Write the goal as" />}
    >
      {shape.description !== null && <Text size="sm">{shape.description}</Text>}
      <form noValidate onSubmit={submit}>
        <Stack gap="md">
          <DraftFields state={state} shape={shape} sought={sought} onFound={found} />
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
          <Command line={sendLine(apiAddress(), name, body)} what="the command that sends this goal" />
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
function SentLine({ goal }: { goal: LiveGoal | null }) {
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

interface SendDialogProps {
  action: string;
  /** What is sent. */
  body: string;
  /** Why it cannot be sent any more; null where it can. */
  reason: string | null;
  opened: boolean;
  onClose: () => void;
  /** @param unasked Whether not to ask again for this action. */
  onSend: (unasked: boolean) => void;
}

/** Asks before a goal is sent that may move a robot. */
function SendDialog({ opened, ...question }: SendDialogProps) {
  return (
    <Dialog opened={opened} onClose={question.onClose} title="Send this goal?">
      <Question {...question} />
    </Dialog>
  );
}

function Question({ action, body, reason, onClose, onSend }: Omit<SendDialogProps, "opened">) {
  const [unasked, setUnasked] = useState(false);
  const robot = useNaming().ownerNameOf(action) ?? "a robot";
  return (
    <Stack gap="md">
      <Text size="sm">
        <strong className={classes.name}>{action}</strong> may move {robot}. Check first that the area is
        clear.
      </Text>
      <Code block className={classes.body} tabIndex={0} role="region" aria-label="What is sent">
        {body}
      </Code>
      <Checkbox
        label="Do not ask again for this action in this browser"
        checked={unasked}
        onChange={(event) => setUnasked(event.currentTarget.checked)}
      />
      <QuestionBar
        keep="Do not send"
        onKeep={onClose}
        go="Send the goal"
        onGo={() => onSend(unasked)}
        reason={reason}
      />
    </Stack>
  );
}

const KEY = "dock-gateway-unasked-actions";

interface Asking {
  /** Whether it is asked before a goal is sent. */
  asks: boolean;
  /** Goals of this type move nothing, so that it is never asked: Fibonacci only counts. */
  harmless: boolean;
  change: (asks: boolean) => void;
}

/** Whether to ask before a goal is sent to an action: until somebody switches that off for it, in this browser. */
function useAsking(action: string, type: string): Asking {
  const [unasked, setUnasked] = useLocalStorage<readonly string[]>({
    key: KEY,
    defaultValue: [],
    getInitialValueInEffect: false,
  });
  const harmless = type.endsWith("/action/Fibonacci");
  return {
    asks: !harmless && !unasked.includes(action),
    harmless,
    change: (asks) =>
      setUnasked((before) => [...before.filter((each) => each !== action), ...(asks ? [] : [action])]),
  };
}
