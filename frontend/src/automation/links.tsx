import { Anchor } from "@mantine/core";
import { Link } from "react-router";
import { OriginBadge } from "../goal/facts";
import { useDecisionOf, useRules } from "./useAutomation";

/** The rules that dock a robot by themselves; nothing where there are none. */
export function RobotRules({ robot }: { robot: string }) {
  const { data: rules = [] } = useRules(30_000);
  const on = rules.filter(
    ({ mode, applies_to }) => mode === "on" && applies_to.some((each) => each.robot === robot),
  );
  if (on.length === 0) return null;
  return (
    <Anchor component={Link} to="/ui/automation" size="sm">
      Automatic docking on ({on.map(({ name }) => name).join(", ")})
    </Anchor>
  );
}

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
