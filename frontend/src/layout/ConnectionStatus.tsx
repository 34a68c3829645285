import { Badge, Tooltip } from "@mantine/core";
import { useFleetTopic } from "../fleet/context";
import type { ConnectionPhase } from "../stream/connection";

const PHASES: Record<ConnectionPhase, { label: string; color: string; hint: string }> = {
  connecting: { label: "connecting", color: "gray.7", hint: "Waiting for the gateway's first message." },
  live: { label: "live", color: "green", hint: "What you see is what the gateway says now." },
  reconnecting: {
    label: "reconnecting",
    color: "orange",
    hint: "The connection to the gateway was lost; trying again by itself.",
  },
  gone: {
    label: "gateway gone",
    color: "red",
    hint: "The gateway has not answered for 10 seconds or more; still trying.",
  },
};

/** On a phone, of the longest words the first are enough: the banner below says them all. */
const SHRINKS = { root: { minWidth: "3rem" } };

export function ConnectionStatus() {
  const { phase } = useFleetTopic("connection");
  const { label, color, hint } = PHASES[phase];
  return (
    <Tooltip label={hint} multiline maw={280}>
      <Badge color={color} data-testid="connection" role="status" styles={SHRINKS}>
        {label}
      </Badge>
    </Tooltip>
  );
}
