import { Anchor, Badge, Text, Title } from "@mantine/core";
import { Link } from "react-router";
import { RobotRules } from "../../automation/links";
import { LinkState } from "../../fleet/badges";
import { useFleetLive, useFleetPart, useNaming } from "../../fleet/context";
import { defaultRobot } from "../../fleet/names";
import { linkOf, placeWords } from "../../fleet/words";
import { LabelButton } from "./LabelButton";
import { RobotSwitcher } from "./RobotSwitcher";
import classes from "./robot.module.css";

/** Which robot this is, whether it is docked, and how it can be reached where something is wrong with that. */
export function RobotHead({ robot, breadcrumb }: { robot: string | null; breadcrumb: boolean }) {
  const name = useFleetPart("robots", (robots) => robot ?? defaultRobot(robots));
  const naming = useNaming();
  const namespace = naming.besides(name);
  return (
    <div className={classes.head}>
      {breadcrumb && (
        <nav aria-label="Breadcrumb" className={classes.crumbs}>
          <Anchor component={Link} to="/">
            Overview
          </Anchor>
          <span aria-hidden="true">›</span>
        </nav>
      )}
      <Title order={1} size="h3" className={classes.name}>
        {naming.nameOf(name)}
      </Title>
      {namespace !== null && <Text c="dimmed">{namespace}</Text>}
      <LabelButton key={name} robot={name} />
      <Facts name={name} />
      <RobotSwitcher robot={name} />
    </div>
  );
}

function Facts({ name }: { name: string }) {
  const live = useFleetLive();
  const place = useFleetPart("robots", (robots) => {
    const docked = robots.get(name)?.docked ?? null;
    return docked === null ? null : placeWords(docked);
  });
  const simulated = useFleetPart("robots", (robots) => robots.get(name)?.simulated === true);
  const link = useFleetPart("robots", (robots) => {
    const known = robots.get(name);
    return known === undefined ? null : linkOf(known);
  });
  return (
    <>
      {place !== null && <span data-testid="place">{place}</span>}
      {simulated && (
        <Badge variant="outline" color="gray">
          simulated
        </Badge>
      )}
      <RobotRules robot={name} />
      {live && link !== null && link !== "connected" && <LinkState link={link} live />}
    </>
  );
}
