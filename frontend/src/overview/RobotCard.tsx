import { Badge, Group, Paper, Title } from "@mantine/core";
import { memo, type ReactNode, useId } from "react";
import { useFleetLive } from "../fleet/context";
import type { Robot } from "../fleet/types";
import { linkOf, placeWords } from "../fleet/words";
import { BatteryMeter } from "./BatteryMeter";
import { LastCell, LinkCell, NowCell } from "./cells";
import classes from "./overview.module.css";

/** The only robot, to be read from the other end of the room. */
export function RobotCard({ robot }: { robot: Robot }) {
  const live = useFleetLive();
  const id = useId();
  return (
    <Paper
      component="section"
      withBorder
      radius="md"
      p={{ base: "md", sm: "lg" }}
      aria-labelledby={id}
      data-testid="robot-card"
    >
      <Head id={id} name={robot.name} simulated={robot.simulated} />
      <dl className={classes.card}>
        <CardFact name="Dock status">
          <span className={classes.place} data-docked={String(robot.docked)}>
            {placeWords(robot.docked)}
          </span>
        </CardFact>
        <CardFact name="Battery">
          <BatteryMeter battery={robot.battery} />
        </CardFact>
        <CardFact name="Now">
          <div className={classes.now}>
            <NowCell robot={robot} live={live} />
          </div>
        </CardFact>
        <CardFact name="Last result">
          <LastCell robot={robot} />
        </CardFact>
        <CardFact name="Connection">
          <LinkCell link={linkOf(robot)} live={live} />
        </CardFact>
      </dl>
    </Paper>
  );
}

/** Rendered apart: the robot changes with each of its battery's messages. */
const Head = memo(function Head({ id, name, simulated }: { id: string; name: string; simulated: boolean }) {
  return (
    <Group gap="sm" mb="sm">
      <Title order={2} size="h3" id={id}>
        {name === "/" ? "Robot" : name}
      </Title>
      {simulated && (
        <Badge variant="outline" color="gray">
          simulated
        </Badge>
      )}
    </Group>
  );
});

function CardFact({ name, children }: { name: string; children: ReactNode }) {
  return (
    <div>
      <dt className={classes.quiet}>{name}</dt>
      <dd>{children}</dd>
    </div>
  );
}
