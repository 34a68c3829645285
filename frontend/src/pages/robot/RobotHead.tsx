import { ActionIcon, Anchor, Badge, Skeleton, Text, Title, Tooltip } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Suspense, useMemo } from "react";
import { Link } from "react-router";
import { Parts } from "../../extension/context";
import { LinkState } from "../../fleet/badges";
import { useFleetLive, useFleetPart, useNaming, useWhyNot } from "../../fleet/context";
import { defaultRobot } from "../../fleet/names";
import { linkOf, namesThere, placeWords } from "../../fleet/words";
import { Dialog } from "../../ui/Dialog";
import { Breakable } from "../../ui/Fact";
import { Guarded } from "../../ui/Guarded";
import { lazyPart } from "../../ui/lazyPart";
import { Icon } from "../../ui/Tool";
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
      {namespace !== null && (
        <Text c="dimmed">
          <Breakable text={namespace} />
        </Text>
      )}
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
      <Parts at="robotHead" robot={name} />
      {live && link !== null && link !== "connected" && <LinkState link={link} live />}
    </>
  );
}

const LabelForm = lazyPart(() => import("./LabelForm"));

/** Opens the name and groups of a robot; has the focus again afterwards. */
function LabelButton({ robot }: { robot: string }) {
  const naming = useNaming();
  const reason = useWhyNot("PUT /label");
  const [opened, dialog] = useDisclosure(false);
  return (
    <>
      <Tooltip label={reason ?? "Name and groups"}>
        <ActionIcon
          variant="subtle"
          color="gray"
          size="lg"
          aria-label={`Name and groups of ${naming.nameOf(robot)}`}
          aria-haspopup="dialog"
          aria-disabled={reason !== null}
          onClick={() => reason === null && dialog.open()}
        >
          <Icon path="M3 17.2V21h3.8L17.9 9.9l-3.8-3.8L3 17.2ZM20.7 7a1 1 0 0 0 0-1.4l-2.3-2.3a1 1 0 0 0-1.4 0l-1.8 1.8 3.8 3.8L20.7 7Z" />
        </ActionIcon>
      </Tooltip>
      <Dialog opened={opened} onClose={dialog.close} title={`Name and groups of ${naming.fullNameOf(robot)}`}>
        <Guarded of={robot}>
          <Suspense fallback={<Skeleton height={180} />}>
            <LabelForm robot={robot} onDone={dialog.close} />
          </Suspense>
        </Guarded>
      </Dialog>
    </>
  );
}

/** Loaded where there are several robots. */
const RobotSelect = lazyPart(() => import("./RobotSelect"));

/** Goes to another robot of the fleet. Nothing where there is no other one. */
function RobotSwitcher({ robot }: { robot: string }) {
  const naming = useNaming();
  const names = useFleetPart("robots", (robots) => namesThere(robots).join("\n"));
  const others = useMemo(
    () => naming.inOrder(names.split("\n").filter((name) => name !== "" && name !== robot)),
    [names, robot, naming],
  );
  if (others.length === 0) return null;
  return (
    <div className={classes.switcher}>
      <Guarded of={robot}>
        <Suspense fallback={<Skeleton height={36} />}>
          <RobotSelect key={robot} others={others} />
        </Suspense>
      </Guarded>
    </div>
  );
}
