import { Alert, Skeleton, Stack, Text, Title } from "@mantine/core";
import { type ReactNode, useMemo } from "react";
import { isHeld, quoted } from "../actions/actions";
import { createCallsApi, servicePath, topicPath, type Use } from "../api/calls";
import type { GraphService, GraphTopic } from "../api/graph";
import { type Command as Operation, useForbidden } from "../api/session";
import { apiAddress } from "../api/site";
import { useFleet, useFleetTopic, useWhyNot } from "../fleet/context";
import { heldStops } from "../stop/held";
import { CommandErrorAlert } from "../ui/errors";
import { MessageTree } from "../ui/MessageTree";
import { useAnswer } from "../ui/requests";
import { sentence } from "../ui/text";
import { MessageForm } from "./MessageForm";

/** How long what the gateway said about a service or a topic is good for (ms). */
const KNOWN_MS = 30_000;

export function useCallsApi() {
  const { http } = useFleet();
  return useMemo(() => createCallsApi(http), [http]);
}

/** The command line that sends a message to a path, for any POSIX shell. */
export function postLine(method: "POST" | "PATCH", path: string, body: string): string {
  return `curl -sX ${method} ${apiAddress()}${path} -H 'Content-Type: application/json' -d ${quoted(body)}`;
}

/** Calls a service that the gateway may call; else why not. */
export function ServiceCall({ service: { name } }: { service: GraphService }) {
  const api = useCallsApi();
  const { data, error, refetch } = useAnswer({
    queryKey: ["service", name],
    queryFn: () => api.service(name),
    staleTime: KNOWN_MS,
  });
  const stopped = useStopped(name);
  const forbidden = useWhyNot("POST /services/{service}");
  const response = data?.response ?? undefined;
  const reads = data?.reads === true;
  return (
    <Permitted
      title="Call"
      use={data?.call}
      operation="POST /services/{service}"
      hint={data?.hint ?? null}
      trouble={
        <CommandErrorAlert command="Looking at the service" error={error} onClose={() => void refetch()} />
      }
      failed={error !== null}
    >
      {data?.request && (
        <MessageForm
          title="Call"
          draft={`service ${name} ${data.type}`}
          schema={data.request}
          verb="Call the service"
          question={reads ? null : `${name} may move a robot. Check first that the area is clear.`}
          reason={forbidden ?? (stopped && !reads ? STOPPED : null)}
          send={(body) => api.call(name, body)}
          line={(body) => postLine("POST", servicePath(name), body)}
        >
          {(answer) => (
            <>
              <Text size="sm" fw={600}>
                It answered
              </Text>
              <MessageTree value={answer} schema={response} label="The response" open={2} />
            </>
          )}
        </MessageForm>
      )}
    </Permitted>
  );
}

/** Publishes on a topic that the gateway may publish on; else why not. */
export function TopicPublish({ topic: { name, types } }: { topic: GraphTopic }) {
  const api = useCallsApi();
  const { data, error, refetch } = useAnswer({
    queryKey: ["topic", name, ...types],
    queryFn: () => api.topic(name),
    staleTime: KNOWN_MS,
    enabled: types.length === 1,
  });
  const stopped = useStopped(name);
  const forbidden = useWhyNot("POST /topics/{topic}");
  const reports = data?.reports === true;
  if (types.length !== 1) return null;
  return (
    <Permitted
      title="Publish"
      use={data?.publish}
      operation="POST /topics/{topic}"
      hint={data?.hint ?? null}
      trouble={
        <CommandErrorAlert command="Looking at the topic" error={error} onClose={() => void refetch()} />
      }
      failed={error !== null}
    >
      {data?.message && (
        <MessageForm
          title="Publish"
          draft={`topic ${name} ${data.type}`}
          schema={data.message}
          verb="Publish the message"
          question={
            reports ? null : `A message on ${name} may move a robot. Check first that the area is clear.`
          }
          reason={forbidden ?? (stopped && !reports ? STOPPED : null)}
          send={(body) => api.publish(name, body)}
          line={(body) => postLine("POST", topicPath(name), body)}
        >
          {(subscribers) => (
            <Text size="sm">
              Published. {subscribers === 0 ? "No one is subscribed to it" : `It went to ${subscribers}`}
              {subscribers === 0 ? "." : subscribers === 1 ? " subscriber." : " subscribers."}
            </Text>
          )}
        </MessageForm>
      )}
    </Permitted>
  );
}

const STOPPED = "The robot is stopped. Release the stop first.";

/** Whether a stop holds for a name on the graph. */
function useStopped(name: string): boolean {
  return isHeld(name, heldStops(useFleetTopic("stop"), useFleetTopic("robots")));
}

interface PermittedProps {
  title: string;
  /** Undefined until the gateway has said it. */
  use: Use | undefined;
  operation: Operation;
  /** Why its messages cannot be written; null where they can. */
  hint: string | null;
  /** Why the gateway has not said it. */
  trouble: ReactNode;
  failed: boolean;
  children: ReactNode;
}

/** A form, or the sentence why there is none: the role, a setting, or a missing package. */
export function Permitted({ title, use, operation, hint, trouble, failed, children }: PermittedProps) {
  const forbidden = useForbidden(operation);
  const reason = forbidden ?? (use?.reason ? `${sentence(use.reason)}.` : null);
  if (use !== undefined && reason === null && hint === null) return children;
  return (
    <Stack gap={4}>
      <Title order={3} size="h5">
        {title}
      </Title>
      {reason !== null ? (
        <Text size="sm" c="dimmed">
          {reason}
        </Text>
      ) : hint !== null ? (
        <Alert color="orange" title="The package of its type is missing">
          <Text size="sm">{sentence(hint)}</Text>
        </Alert>
      ) : failed ? (
        trouble
      ) : (
        <Skeleton height={40} role="status" aria-busy="true" aria-label="Loading" />
      )}
    </Stack>
  );
}
