import { Badge, Tooltip, VisuallyHidden } from "@mantine/core";
import type { ActionServer } from "../api/types";
import { useLive, useTopic } from "../store/context";
import { foreignName, whatToStart } from "./families";

/** Whether the docking server can be reached; that it answers, as it should, is said to screen readers alone. */
export function ActionServerStatus() {
  const server = useTopic("actionServer");
  const live = useLive();
  const foreign = server === null ? null : foreignName(server);
  const trouble = describe(live ? server : null);
  return (
    <div role="status" data-testid="action-server">
      {trouble === null ? (
        <>
          {foreign !== null && (
            <Tooltip label={`${server?.action_name} (${server?.action_type})`} multiline maw={320}>
              <Badge color="gray" variant="light" data-testid="docking-family">
                {foreign}
              </Badge>
            </Tooltip>
          )}
          <VisuallyHidden>action server answering</VisuallyHidden>
        </>
      ) : (
        <Tooltip label={trouble.hint} multiline maw={280}>
          <Badge color={trouble.color}>{trouble.label}</Badge>
        </Tooltip>
      )}
    </div>
  );
}

/** What is wrong with it; null where nothing is. */
function describe(server: ActionServer | null): { label: string; color: string; hint: string } | null {
  if (server === null) {
    return {
      label: "action server unknown",
      color: "gray.7",
      hint: "Known again when the gateway is connected.",
    };
  }
  if (!server.available) {
    return {
      label: "action server not there",
      color: "red",
      hint: `No action server for ${server.action_name}. Start ${whatToStart("dock", server)}.`,
    };
  }
  if (server.duplicate) {
    return {
      label: "two action servers",
      color: "red",
      hint: `More than one action server serves ${server.action_name}: each of them would move the robot.`,
    };
  }
  return server.answering
    ? null
    : {
        label: "action server silent",
        color: "orange",
        hint: `${server.action_name} is on the graph but does not answer. It may be frozen.`,
      };
}
