import { Tabs } from "@mantine/core";
import { useState } from "react";
import { useSearchParams } from "react-router";
import { useFleetLive, useFleetPart } from "../../fleet/context";
import { DEVELOPER, OPERATE, readTab, type Tab, withTab } from "../../fleet/path";
import { RobotHead } from "./RobotHead";
import { RobotPanels } from "./RobotPanels";
import { RobotScope } from "./RobotScope";
import classes from "./robot.module.css";
import { UnknownRobot } from "./UnknownRobot";

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
