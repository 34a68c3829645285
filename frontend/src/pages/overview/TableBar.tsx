import type { Robot } from "@dock-gateway/client";
import { Button, CloseButton, Menu } from "@mantine/core";
import { Link } from "react-router";
import { useFleetLive, useFleetTopic } from "../../fleet/context";
import { useOperate } from "../../operations/context";
import { OPERATION_NAMES, operationsHere, whyNot } from "../../operations/operation";
import { ReasonButton } from "../../ui/ReasonButton";
import { SavedViews } from "../../ui/SavedViews";
import { overviewView, type View } from "./list";
import classes from "./overview.module.css";
import type { ColumnChoice } from "./TableHead";
import type { Selection } from "./useSelection";

interface TableBarProps {
  /** How many robots are listed, and how many there are. */
  listed: number;
  all: number;
  view: View;
  selection: Selection;
  columns: ColumnChoice;
}

/** Above the table, and always as high: how many robots there are, or what can be done to those that are selected. */
export function TableBar({ listed, all, view, selection, columns }: TableBarProps) {
  const count = selection.names.length;
  const { group } = view;
  return (
    <div className={classes.bar} data-selected={count > 0 || undefined}>
      <span role="status" className={classes.count}>
        {count > 0 ? `${count} selected` : listed === all ? `${all} robots` : `${listed} of ${all} robots`}
      </span>
      {count > 0 ? (
        <>
          <Bulk names={selection.names} />
          {count < listed && (
            <Button variant="subtle" size="compact-sm" className={classes.more ?? ""} onClick={selection.all}>
              Select all {listed}
            </Button>
          )}
          <CloseButton
            aria-label="Clear the selection"
            className={classes.end ?? ""}
            onClick={selection.none}
          />
        </>
      ) : (
        <div className={classes.end}>
          <Button
            component={Link}
            to={group === null ? "/ui/wall" : `/ui/wall?group=${encodeURIComponent(group)}`}
            variant="subtle"
            size="compact-sm"
            color="gray"
            title="Large tiles for a screen on a wall"
          >
            Wall
          </Button>
          {/* A view has its columns, too, whatever this browser shows otherwise. */}
          <SavedViews
            page="overview"
            query={overviewView.write({ ...view, hidden: columns.hidden }).toString()}
            variant="subtle"
          />
          <ColumnsMenu choice={columns} />
        </div>
      )}
    </div>
  );
}

function Bulk({ names }: { names: readonly string[] }) {
  const operate = useOperate();
  const live = useFleetLive();
  const robots = useFleetTopic("robots");
  const chosen = names.flatMap((name) => robots.get(name) ?? []);
  const primary = chosen.every(({ docked }) => docked) ? "undock" : "dock";
  return (
    <fieldset className={classes.bulk}>
      <legend className={classes.legend}>Commands for the selected robots</legend>
      {operationsHere().map((operation) => (
        <ReasonButton
          key={operation}
          size="compact-md"
          variant={operation === primary ? "filled" : operation === "stop" ? "outline" : "default"}
          {...(operation === "stop" ? { color: "red" } : {})}
          reason={whyNone(chosen, (robot) => whyNot(operation, robot, live))}
          onClick={() => operate(operation, names)}
        >
          {OPERATION_NAMES[operation]}
        </ReasonButton>
      ))}
    </fieldset>
  );
}

/** Why something can be done to none of the robots; null where it can be done to one of them. */
function whyNone(robots: readonly Robot[], why: (robot: Robot) => string | null): string | null {
  const reasons = new Set(robots.map(why));
  if (reasons.has(null)) return null;
  const [only] = reasons;
  return reasons.size === 1 && only != null ? only : "None of the selected robots can do this now.";
}

/** Chooses the columns of the table. */
function ColumnsMenu({ choice: { shown, optional, toggle } }: { choice: ColumnChoice }) {
  return (
    <Menu closeOnItemClick={false} position="bottom-end" withInitialFocusPlaceholder={false}>
      <Menu.Target>
        <Button variant="subtle" size="compact-sm" color="gray">
          Columns
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        {optional.map(({ sort, name }, index) => (
          <Menu.CheckboxItem
            key={sort}
            checked={shown.has(sort)}
            onChange={() => toggle(sort)}
            data-autofocus={index === 0 || undefined}
          >
            {name}
          </Menu.CheckboxItem>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
