import { Checkbox, Table, VisuallyHidden } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import { type Mark, SeverityMark } from "../../alerts/marks";
import type { Attention } from "../../alerts/order";
import type { Robot } from "../../api/types";
import { LinkState } from "../../fleet/badges";
import { robotName } from "../../fleet/names";
import { robotPath } from "../../fleet/path";
import { linkOf, placeWords } from "../../fleet/words";
import { BatteryMeter } from "./BatteryMeter";
import { LastCell, NowCell } from "./cells";
import type { Sort } from "./list";
import classes from "./overview.module.css";
import { RowMenu } from "./RowMenu";

const MARKS: Record<Exclude<Attention, 0>, { mark: Mark; words: string }> = {
  1: { mark: "acknowledged", words: "Acknowledged alert" },
  2: { mark: "warning", words: "Warning" },
  3: { mark: "critical", words: "Critical alert" },
};

interface RobotRowProps {
  robot: Robot;
  /** Its place in the list. */
  index: number;
  attention: Attention;
  live: boolean;
  /** The columns that are shown. */
  shown: ReadonlySet<Sort>;
  selected: boolean;
  onSelect: (name: string, range: boolean) => void;
  /** Measures the height of the row. */
  measure: (row: HTMLTableRowElement | null) => void;
}

/** A robot in the table. Re-rendered only where that robot is another, as the store keeps those that did not change. */
export const RobotRow = memo(function RobotRow({
  robot,
  index,
  attention,
  live,
  shown,
  selected,
  onSelect,
  measure,
}: RobotRowProps) {
  const place = placeWords(robot.docked);
  const link = linkOf(robot);
  return (
    <Table.Tr
      ref={measure}
      className={classes.row}
      data-testid={`robot ${robot.name}`}
      data-robot={robot.name}
      data-index={index}
      data-selected={selected || undefined}
      aria-rowindex={index + 2}
    >
      <Table.Td className={classes.selectCell}>
        <Checkbox
          size="xs"
          className={classes.above ?? ""}
          aria-label={`Select ${robotName(robot)}`}
          checked={selected}
          onChange={(event) => onSelect(robot.name, (event.nativeEvent as MouseEvent).shiftKey)}
        />
      </Table.Td>
      <Table.Th scope="row" className={classes.nameCell}>
        {attention > 0 && <AttentionMark attention={attention as Exclude<Attention, 0>} />}
        <Link to={robotPath(robot.name)} className={classes.name}>
          {robotName(robot)}
        </Link>
        {robot.display_name !== null && <span className={classes.quiet}> {robot.name}</span>}
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
        {robot.groups.length > 0 && <span className={classes.groupLine}>{robot.groups.join(", ")}</span>}
      </Table.Th>
      {shown.has("place") && (
        <Table.Td className={classes.wide}>
          <span className={classes.place} data-docked={String(robot.docked)}>
            {place}
          </span>
        </Table.Td>
      )}
      {shown.has("battery") && (
        <Table.Td>
          <BatteryMeter battery={robot.battery} charging={robot.charging} />
        </Table.Td>
      )}
      {shown.has("goal") && (
        <Table.Td>
          <div className={classes.now}>
            <NowCell robot={robot} live={live} />
          </div>
        </Table.Td>
      )}
      {shown.has("last") && (
        <Table.Td className={classes.wide}>
          <LastCell robot={robot} />
        </Table.Td>
      )}
      {shown.has("groups") && (
        <Table.Td className={`${classes.wide} ${classes.groups}`}>{robot.groups.join(", ")}</Table.Td>
      )}
      {shown.has("link") && (
        <Table.Td className={classes.wide}>
          <LinkState link={link} live={live} />
        </Table.Td>
      )}
      <Table.Td className={classes.menuCell}>
        <RowMenu robot={robot} live={live} />
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
