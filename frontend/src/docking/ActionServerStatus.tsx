import { Badge, Tooltip } from "@mantine/core";
import type { ActionServer } from "../api/types";
import { useLive, useTopic } from "../store/context";

export function ActionServerStatus() {
  const server = useTopic("actionServer");
  const live = useLive();
  const { label, color, hint } = describe(live ? server : null);
  return (
    <Tooltip label={hint} multiline maw={280}>
      <Badge color={color} data-testid="action-server" role="status">
        {label}
      </Badge>
    </Tooltip>
  );
}

function describe(server: ActionServer | null): { label: string; color: string; hint: string } {
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
      hint: `Nobody offers ${server.action_name}. Start connect_to_charging_dock_server.`,
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
    ? { label: "action server answering", color: "green", hint: `${server.action_name} answers.` }
    : {
        label: "action server silent",
        color: "orange",
        hint: `${server.action_name} is on the graph but does not answer. It may be frozen.`,
      };
}
