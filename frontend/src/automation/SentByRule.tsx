import { Anchor } from "@mantine/core";
import { Link } from "react-router";
import { OriginBadge } from "../goal/OriginBadge";
import { useDecisionOf } from "./useAutomation";

/** The rule that sent a goal, once it is known. */
export function SentByRule({ goalId }: { goalId: string }) {
  const decision = useDecisionOf(goalId);
  if (decision === null) return <OriginBadge origin="automation" />;
  return (
    <Anchor component={Link} to="/ui/automation">
      Automatic docking: {decision.rule_name}
    </Anchor>
  );
}
