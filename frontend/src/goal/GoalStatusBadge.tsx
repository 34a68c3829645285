import { Badge } from "@mantine/core";
import type { GoalStatus } from "../api/types";
import { STATUS_COLORS } from "./words";

export function GoalStatusBadge({ status, testId }: { status: GoalStatus; testId?: string }) {
  return (
    <Badge component="span" color={STATUS_COLORS[status]} data-testid={testId}>
      {status}
    </Badge>
  );
}
