import { Alert, Anchor, List, Tabs, Text } from "@mantine/core";
import { type ReactNode, useEffect, useMemo, useState } from "react";
import { Link, useSearchParams } from "react-router";
import { useFleet, useFleetLive, useFleetPart, useFleetTopic, useNaming } from "../../fleet/context";
import { DEVELOPER, defaultRobot, OPERATE, readTab, robotPath, type Tab, withTab } from "../../fleet/names";
import { namesThere } from "../../fleet/words";
import { type Services, ServicesProvider } from "../../store/context";
import { usePageTitle } from "../../ui/Section";
import { RobotHead } from "./RobotHead";
import { RobotPanels } from "./RobotPanels";
import classes from "./robot.module.css";

/** One robot: `?robot=/robot1`, without it the one that the gateway is configured for. */
export default function RobotPage() {
  const [query] = useSearchParams();
  const asked = query.get("robot");
  const robot = asked === null ? null : `/${asked.replace(/^\/+|\/+$/g, "")}`;
  const naming = useNaming();
  usePageTitle(naming.nameOf(useFleetPart("robots", (robots) => robot ?? defaultRobot(robots))));
  return <RobotView robot={robot} breadcrumb />;
}

/** Gives what is inside one robot: its commands and what is known of it, read along while this is shown. */
export function RobotScope({ robot, children }: { robot: string | null; children: ReactNode }) {
  const { openRobot } = useFleet();
  const [services, setServices] = useState<Services | null>(null);

  useEffect(() => {
    const opened = openRobot(robot);
    setServices(opened.services);
    return () => {
      opened.close();
      setServices(null);
    };
  }, [openRobot, robot]);

  return services === null ? null : <ServicesProvider value={services}>{children}</ServicesProvider>;
}

interface RobotViewProps {
  /** Its namespace; null for the one that the gateway is configured for. */
  robot: string | null;
  /** Whether this is a page of its own, below the overview. */
  breadcrumb?: boolean;
}

/** All that there is to see and do about one robot; which tab is in the page's address. */
export function RobotView({ robot, breadcrumb = false }: RobotViewProps) {
  const [query, setQuery] = useSearchParams();
  const tab = readTab(query);
  const [developed, setDeveloped] = useState(false);
  if (tab === DEVELOPER && !developed) setDeveloped(true);
  const live = useFleetLive();
  const known = useFleetPart("robots", (robots) => robot === null || robots.has(robot));
  // One that was known stays: after a restart the gateway finds the robots one by one.
  const [seen, setSeen] = useState<string | null | undefined>(undefined);
  if (known && seen !== robot) setSeen(robot);
  const wasKnown = known || seen === robot;
  const missing = live && !known;
  const shown = !missing || wasKnown;
  return (
    <Tabs
      value={tab}
      onChange={(next) => setQuery(withTab(query, next as Tab), { replace: true })}
      className={classes.view}
    >
      <div className={classes.top}>
        <RobotHead robot={robot} breadcrumb={breadcrumb} />
        {shown && (
          <Tabs.List className={classes.tabs}>
            <Tabs.Tab value={OPERATE}>Operate</Tabs.Tab>
            <Tabs.Tab value={DEVELOPER}>Developer</Tabs.Tab>
          </Tabs.List>
        )}
      </div>
      {missing && robot !== null && <UnknownRobot robot={robot} wasKnown={wasKnown} />}
      {shown && (
        <RobotScope key={robot} robot={robot}>
          <RobotPanels developer={developed} />
        </RobotScope>
      )}
    </Tabs>
  );
}

/** Says that the gateway knows no such robot, and which ones it knows. */
function UnknownRobot({ robot, wasKnown }: { robot: string; wasKnown: boolean }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const names = useMemo(() => naming.inOrder(namesThere(robots)), [robots, naming]);
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
