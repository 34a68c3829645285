import { Button, Paper, Table, Text } from "@mantine/core";
import { useMemo } from "react";
import { useSearchParams } from "react-router";
import { attentionOf } from "../alerts/order";
import { useFleetLive, useFleetTopic } from "../fleet/context";
import type { Robot } from "../fleet/types";
import { useNaming } from "../fleet/useNaming";
import { Filters } from "./Filters";
import { listed, readView, type Sort, type View, writeView } from "./list";
import classes from "./overview.module.css";
import { RobotRow } from "./RobotRow";

interface Column {
  sort: Sort;
  name: string;
  /** Left out where the window is narrow: the robot's own cell says it there. */
  wide?: boolean;
}

const COLUMNS: readonly Column[] = [
  { sort: "name", name: "Robot" },
  { sort: "place", name: "Dock status", wide: true },
  { sort: "battery", name: "Battery" },
  { sort: "goal", name: "Now" },
  { sort: "last", name: "Last result", wide: true },
  { sort: "groups", name: "Groups", wide: true },
  { sort: "link", name: "Connection", wide: true },
];

/** All robots, a row each, those with alerts first; what is shown and in which order is in the page's address. */
export function RobotTable({ robots }: { robots: readonly Robot[] }) {
  const alerts = useFleetTopic("alerts");
  const live = useFleetLive();
  const attentions = useMemo(() => attentionOf(alerts), [alerts]);
  const [query, setQuery] = useSearchParams();
  const view = useMemo(() => readView(query), [query]);
  const naming = useNaming();
  const groups = useMemo(() => naming.groups(), [naming]);
  const grouped = groups.length > 0;
  const rows = useMemo(() => listed(robots, view, attentions), [robots, view, attentions]);
  const change = (next: Partial<View>) => setQuery(writeView({ ...view, ...next }), { replace: true });

  return (
    <>
      <Filters robots={robots} attentions={attentions} view={view} groups={groups} onChange={change} />
      <Paper withBorder radius="md" className={classes.paper}>
        <Table
          className={classes.table}
          data-grouped={grouped || undefined}
          verticalSpacing="xs"
          horizontalSpacing="sm"
          highlightOnHover
        >
          <caption className={classes.caption}>
            {rows.length === robots.length
              ? `${rows.length} robots`
              : `${rows.length} of ${robots.length} robots`}
          </caption>
          <Table.Thead>
            <Table.Tr>
              {COLUMNS.filter(({ sort }) => grouped || sort !== "groups").map((column) => (
                <HeaderCell key={column.sort} column={column} view={view} onSort={change} />
              ))}
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {rows.map((robot) => (
              <RobotRow
                key={robot.name}
                robot={robot}
                attention={attentions.get(robot.name) ?? 0}
                live={live}
                grouped={grouped}
              />
            ))}
          </Table.Tbody>
        </Table>
        {rows.length === 0 && (
          <div className={classes.none}>
            <Text>No robot is like that now.</Text>
            <Button
              variant="default"
              size="compact-md"
              onClick={() => change({ show: "all", text: "", group: null })}
            >
              Show all {robots.length}
            </Button>
          </div>
        )}
      </Paper>
    </>
  );
}

interface HeaderCellProps {
  column: Column;
  view: View;
  onSort: (change: Partial<View>) => void;
}

/** Sorts ascending, descending, and then no more. */
function HeaderCell({ column: { sort, name, wide = false }, view, onSort }: HeaderCellProps) {
  const sorted = view.sort === sort;
  const direction = !sorted ? "none" : view.descending ? "descending" : "ascending";
  const press = () => {
    if (!sorted) onSort({ sort, descending: false });
    else if (!view.descending) onSort({ descending: true });
    else onSort({ sort: "attention", descending: false });
  };
  return (
    <Table.Th
      aria-sort={direction}
      className={wide ? `${classes.column} ${classes.wide}` : classes.column}
      data-column={sort}
    >
      <button type="button" className={classes.sort} onClick={press}>
        {name}
        <span aria-hidden="true" className={classes.arrow} data-direction={direction}>
          {direction === "descending" ? "▼" : "▲"}
        </span>
      </button>
    </Table.Th>
  );
}
