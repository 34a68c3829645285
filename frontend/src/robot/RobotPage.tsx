import { Group, Title } from "@mantine/core";
import { useState } from "react";
import { useSearchParams } from "react-router";
import { useFleetLive, useFleetPart } from "../fleet/context";
import { linkOf } from "../fleet/words";
import { LinkCell } from "../overview/cells";
import { defaultRobot } from "../stop/held";
import { usePageTitle } from "../ui/usePageTitle";
import { RobotPanels } from "./RobotPanels";
import { RobotScope } from "./RobotScope";
import { UnknownRobot } from "./UnknownRobot";

/** One robot: `?robot=/robot1`, without it the one that the gateway is configured for. */
export default function RobotPage() {
  const [query] = useSearchParams();
  const asked = query.get("robot");
  const robot = asked === null ? null : `/${asked.replace(/^\/+|\/+$/g, "")}`;
  const name = robot ?? "Robot";
  usePageTitle(name);
  return (
    <>
      <Group gap="sm" align="baseline">
        <Title order={1} size="h3">
          {name}
        </Title>
        <Reachability robot={robot} />
      </Group>
      <Known key={robot} robot={robot} />
    </>
  );
}

/** Its panels. One that was known stays: after a restart the gateway finds the robots one by one. */
function Known({ robot }: { robot: string | null }) {
  const live = useFleetLive();
  const known = useFleetPart("robots", (robots) => robot === null || robots.has(robot));
  const [wasKnown, setWasKnown] = useState(known);
  if (known && !wasKnown) setWasKnown(true);
  const missing = live && !known && robot !== null;
  return (
    <>
      {missing && <UnknownRobot robot={robot} wasKnown={wasKnown} />}
      {(!missing || wasKnown) && (
        <RobotScope robot={robot}>
          <RobotPanels />
        </RobotScope>
      )}
    </>
  );
}

/** How the robot can be reached, where something is wrong with that. */
function Reachability({ robot }: { robot: string | null }) {
  const live = useFleetLive();
  const link = useFleetPart("robots", (robots) => {
    const known = robots.get(robot ?? defaultRobot(robots));
    return known === undefined ? null : linkOf(known);
  });
  if (link === null || link === "connected" || !live) return null;
  return <LinkCell link={link} live />;
}
