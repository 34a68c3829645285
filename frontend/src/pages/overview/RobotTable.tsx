import { Button, Paper, Table, Text } from "@mantine/core";
import { Fragment, useMemo, useRef, useState } from "react";
import { useSearchParams } from "react-router";
import { attentionOf } from "../../alerts/order";
import type { Robot } from "../../api/types";
import { useFleetLive, useFleetTopic, useNaming } from "../../fleet/context";
import { useColumns } from "./columns";
import { Filters } from "./Filters";
import { listed, readView, type View, writeView } from "./list";
import classes from "./overview.module.css";
import { RobotRow } from "./RobotRow";
import { TableBar } from "./TableBar";
import { TableHead } from "./TableHead";
import { useRowWindow } from "./useRowWindow";
import { useSelection } from "./useSelection";

/** All robots, a row each, those with alerts first; what is shown and in which order is in the page's address. */
export default function RobotTable({ robots }: { robots: readonly Robot[] }) {
  const alerts = useFleetTopic("alerts");
  const live = useFleetLive();
  const attentions = useMemo(() => attentionOf(alerts), [alerts]);
  const [query, setQuery] = useSearchParams();
  const view = useMemo(() => readView(query), [query]);
  const naming = useNaming();
  const grouped = useMemo(() => naming.groups().length > 0, [naming]);
  const change = (next: Partial<View>) => setQuery(writeView({ ...view, ...next }), { replace: true });
  const columns = useColumns(grouped, view.hidden, (hidden) => change({ hidden }));
  const { shown } = columns;
  const rows = useMemo(() => listed(robots, view, attentions), [robots, view, attentions]);
  const selection = useSelection(rows);

  const body = useRef<HTMLTableSectionElement>(null);
  const keys = useMemo(() => rows.map(({ name }) => name), [rows]);
  const [focused, setFocused] = useState<string | null>(null);
  const onPage = useRowWindow(body, keys, focused === null ? -1 : keys.indexOf(focused));

  return (
    <>
      <Filters robots={robots} attentions={attentions} view={view} onChange={change} />
      <Paper withBorder radius="md" className={classes.paper}>
        <TableBar
          listed={rows.length}
          all={robots.length}
          view={view}
          selection={selection}
          columns={columns}
        />
        <Table
          className={classes.table}
          aria-label="Robots"
          aria-rowcount={rows.length + 1}
          data-grouped={shown.has("groups") || undefined}
          verticalSpacing="xs"
          horizontalSpacing="sm"
          highlightOnHover
        >
          <TableHead shown={shown} view={view} selection={selection} listed={rows.length} onSort={change} />
          <Table.Tbody
            ref={body}
            onFocus={(event) =>
              setFocused(event.target.closest<HTMLElement>("[data-robot]")?.dataset.robot ?? null)
            }
            onBlur={() => setFocused(null)}
          >
            {onPage.rows.map(({ index, key, gap }) => {
              const robot = rows[index];
              return (
                robot !== undefined && (
                  <Fragment key={key}>
                    <Gap height={gap} />
                    <RobotRow
                      robot={robot}
                      index={index}
                      attention={attentions.get(robot.name) ?? 0}
                      live={live}
                      shown={shown}
                      selected={selection.has(robot.name)}
                      onSelect={selection.toggle}
                      measure={onPage.measure}
                    />
                  </Fragment>
                )
              );
            })}
            <Gap height={onPage.rest} />
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

/** As high as the rows that are not on the page. */
function Gap({ height }: { height: number }) {
  if (height === 0) return null;
  // biome-ignore lint/a11y/noAriaHiddenOnFocusable: a row without cells cannot have the focus
  return <tr aria-hidden="true" className={classes.gap} style={{ height }} />;
}
