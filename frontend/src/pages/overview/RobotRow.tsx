import type { Robot } from "@dock-gateway/client";
import { ActionIcon, Checkbox, Menu, Table, Tooltip, VisuallyHidden } from "@mantine/core";
import { memo, useId, useState } from "react";
import { Link } from "react-router";
import { type Mark, SeverityMark } from "../../alerts/marks";
import type { Attention } from "../../alerts/order";
import { LinkState } from "../../fleet/badges";
import { robotName, robotPath } from "../../fleet/names";
import { linkOf, placeWords } from "../../fleet/words";
import { useOperate } from "../../operations/context";
import { moveOf, OPERATION_NAMES, type Operation, operationsHere, whyNot } from "../../operations/operation";
import { Icon } from "../../ui/Tool";
import { BatteryMeter, LastCell, NowCell } from "./cells";
import type { Sort } from "./list";
import classes from "./overview.module.css";

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
      data-away={link === "away" || undefined}
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
            <NowCell robot={robot} live={live && link !== "away"} />
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

/** What can be done to the robot of a row, in a menu at its end. */
const RowMenu = memo(function RowMenu({ robot, live }: { robot: Robot; live: boolean }) {
  const [opened, setOpened] = useState(false);
  return (
    <Menu opened={opened} onChange={setOpened} position="bottom-end" withInitialFocusPlaceholder={false}>
      <Menu.Target>
        <ActionIcon
          variant="subtle"
          color="gray"
          size="md"
          className={classes.menu ?? ""}
          aria-label={`Commands for ${robotName(robot)}`}
        >
          <Icon path="M12 4a2 2 0 1 1 0 4 2 2 0 0 1 0-4Zm0 6a2 2 0 1 1 0 4 2 2 0 0 1 0-4Zm0 6a2 2 0 1 1 0 4 2 2 0 0 1 0-4Z" />
        </ActionIcon>
      </Menu.Target>
      <Menu.Dropdown>
        {opened &&
          operationsHere().map((operation, index) => (
            <Item
              key={operation}
              operation={operation}
              robot={robot}
              live={live}
              data-autofocus={index === 0 || undefined}
            />
          ))}
      </Menu.Dropdown>
    </Menu>
  );
});

interface ItemProps {
  operation: Operation;
  robot: Robot;
  live: boolean;
  "data-autofocus": true | undefined;
}

/** Says in a tooltip why it cannot be used; it can have the focus all the same. */
function Item({ operation, robot, live, ...focus }: ItemProps) {
  const operate = useOperate();
  const reason = whyNot(operation, robot, live);
  const id = useId();
  const disabled = reason !== null;
  return (
    <Tooltip label={reason} disabled={!disabled} multiline maw={300} position="left">
      <div>
        <Menu.Item
          {...focus}
          {...(operation === "stop" ? { c: "var(--mantine-color-error)" } : {})}
          closeMenuOnClick={!disabled}
          data-disabled={disabled || undefined}
          aria-disabled={disabled || undefined}
          aria-describedby={disabled ? id : undefined}
          aria-haspopup={moveOf(operation) !== null && !robot.simulated ? "dialog" : undefined}
          onClick={() => {
            if (!disabled) operate(operation, [robot.name]);
          }}
        >
          {OPERATION_NAMES[operation]}
        </Menu.Item>
        <span id={id} hidden>
          {reason}
        </span>
      </div>
    </Tooltip>
  );
}
