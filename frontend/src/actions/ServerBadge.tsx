import { Badge } from "@mantine/core";
import type { ActionInfo } from "../api/types";

/** Whether there is an action server, and how it does. */
export function ServerBadge({ action, live }: { action: ActionInfo | null; live: boolean }) {
  const { words, color } = describe(live ? action : null);
  return (
    <Badge component="span" color={color} data-testid="server">
      {words}
    </Badge>
  );
}

function describe(action: ActionInfo | null): { words: string; color: string } {
  if (action === null) return { words: "unknown", color: "gray.7" };
  if (!action.installed) return { words: "package missing", color: "orange" };
  if (!action.available) return { words: "not there", color: "red" };
  if (action.duplicate) return { words: "two servers", color: "red" };
  return action.answering ? { words: "answering", color: "green" } : { words: "silent", color: "orange" };
}
