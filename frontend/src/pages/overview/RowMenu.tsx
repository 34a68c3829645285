import { ActionIcon, Menu, Tooltip } from "@mantine/core";
import { memo, useId, useState } from "react";
import type { Robot } from "../../api/types";
import { robotName } from "../../fleet/names";
import { useOperate } from "../../operations/context";
import { moveOf, OPERATION_NAMES, OPERATIONS, type Operation, whyNot } from "../../operations/operation";
import classes from "./overview.module.css";

/** What can be done to the robot of a row, in a menu at its end. */
export const RowMenu = memo(function RowMenu({ robot, live }: { robot: Robot; live: boolean }) {
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
          <svg width="18" height="18" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
            <path d="M12 4a2 2 0 1 1 0 4 2 2 0 0 1 0-4Zm0 6a2 2 0 1 1 0 4 2 2 0 0 1 0-4Zm0 6a2 2 0 1 1 0 4 2 2 0 0 1 0-4Z" />
          </svg>
        </ActionIcon>
      </Menu.Target>
      <Menu.Dropdown>
        {opened &&
          OPERATIONS.map((operation, index) => (
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
