import { Alert, Anchor, List, Text } from "@mantine/core";
import { useMemo } from "react";
import { Link } from "react-router";
import { useFleetTopic } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { robotPath } from "../../fleet/path";
import { useNaming } from "../../fleet/useNaming";
import { isThere } from "../../fleet/words";

/** Says that the gateway knows no such robot, and which ones it knows. */
export function UnknownRobot({ robot, wasKnown }: { robot: string; wasKnown: boolean }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const names = useMemo(
    () => [...robots.values()].flatMap((each) => (isThere(each) ? [each.name] : [])).sort(byName),
    [robots],
  );
  return (
    <Alert color="orange" title={wasKnown ? `${robot} has left the ROS graph` : `No robot ${robot} is known`}>
      <Text size="sm">
        This page shows it as soon as it appears.{" "}
        {names.length > 0 ? "These robots are known:" : "No other robot is known either."}
      </Text>
      <List size="sm">
        {names.map((name) => (
          <List.Item key={name}>
            <Anchor component={Link} to={robotPath(name)} inherit underline="always">
              {naming.fullNameOf(name)}
            </Anchor>
          </List.Item>
        ))}
      </List>
    </Alert>
  );
}
