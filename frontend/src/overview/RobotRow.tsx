import { Table, VisuallyHidden } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import type { Attention } from "../alerts/order";
import { type Mark, SeverityMark } from "../alerts/SeverityMark";
import { LinkState } from "../fleet/LinkState";
import type { Robot } from "../fleet/types";
import { displayName, linkOf, placeWords } from "../fleet/words";
import { robotPath } from "../robot/path";
import { BatteryMeter } from "./BatteryMeter";
import { LastCell, NowCell } from "./cells";
import classes from "./overview.module.css";

const MARKS: Record<Exclude<Attention, 0>, { mark: Mark; words: string }> = {
  1: { mark: "acknowledged", words: "Acknowledged alert" },
  2: { mark: "warning", words: "Warning" },
  3: { mark: "critical", words: "Critical alert" },
};

interface RobotRowProps {
  robot: Robot;
  attention: Attention;
  live: boolean;
}

/** A robot in the table. Rendered anew only where that robot is another, as the store keeps those that did not change. */
export const RobotRow = memo(function RobotRow({ robot, attention, live }: RobotRowProps) {
  const place = placeWords(robot.docked);
  const link = linkOf(robot);
  return (
    <Table.Tr className={classes.row} data-testid={`robot ${robot.name}`}>
      <Table.Th scope="row" className={classes.nameCell}>
        {attention > 0 && <AttentionMark attention={attention as Exclude<Attention, 0>} />}
        <Link to={robotPath(robot.name)} className={classes.name}>
          {displayName(robot.name)}
        </Link>
        {robot.simulated && <span className={`${classes.quiet} ${classes.simulated}`}> simulated</span>}
        <span className={classes.narrow}>
          {place}
          {robot.simulated && ", simulated"}
          {link !== "connected" && (
            <>
              {", "}
              <LinkState link={link} live={live} />
            </>
          )}
        </span>
      </Table.Th>
      <Table.Td className={classes.wide}>
        <span className={classes.place} data-docked={String(robot.docked)}>
          {place}
        </span>
      </Table.Td>
      <Table.Td>
        <BatteryMeter battery={robot.battery} />
      </Table.Td>
      <Table.Td>
        <div className={classes.now}>
          <NowCell robot={robot} live={live} />
        </div>
      </Table.Td>
      <Table.Td className={classes.wide}>
        <LastCell robot={robot} />
      </Table.Td>
      <Table.Td className={classes.wide}>
        <LinkState link={link} live={live} />
      </Table.Td>
    </Table.Tr>
  );
});

function AttentionMark({ attention }: { attention: Exclude<Attention, 0> }) {
  const { mark, words } = MARKS[attention];
  return (
    <span title={words} className={classes.attention}>
      <SeverityMark mark={mark} />
      <VisuallyHidden>{words}: </VisuallyHidden>
    </span>
  );
}
