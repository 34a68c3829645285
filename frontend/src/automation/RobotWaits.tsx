import { Anchor, Text } from "@mantine/core";
import { Link } from "react-router";
import type { Rule } from "../api/automation";
import { useNaming } from "../fleet/context";
import { robotPath } from "../fleet/path";
import classes from "./automation.module.css";
import { WAITS } from "./words";

/** The robots that a rule applies to now, and what it waits for. */
export function RobotWaits({ rule }: { rule: Rule }) {
  const naming = useNaming();
  const count = rule.applies_to.length;
  if (count === 0) {
    return (
      <Text size="sm" c="dimmed">
        Applies to no robot now
      </Text>
    );
  }
  return (
    <details className={classes.waits}>
      <summary>Applies to {count === 1 ? "one robot" : `${count} robots`} now</summary>
      <ul>
        {rule.applies_to.map(({ robot, waits_for }) => (
          <li key={robot}>
            <Anchor component={Link} to={robotPath(robot)} size="sm" underline="always">
              {naming.fullNameOf(robot)}
            </Anchor>
            {rule.mode !== "off" && (
              <Text span size="sm" c="dimmed">
                {WAITS[waits_for]}
              </Text>
            )}
          </li>
        ))}
      </ul>
    </details>
  );
}
