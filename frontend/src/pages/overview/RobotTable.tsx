import type { Robot } from "@dock-gateway/client";
import { Button, NativeSelect, Paper, Table, Text, TextInput } from "@mantine/core";
import { Fragment, useMemo, useRef, useState } from "react";
import { attentionOf } from "../../alerts/order";
import { useFleetLive, useFleetTopic, useNaming } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { GroupSelect } from "../../fleet/RobotFields";
import { useAddress } from "../../ui/address";
import { type Attentions, listed, matches, overviewView, SHOW_WORDS, SHOWS, siteOf, type View } from "./list";
import classes from "./overview.module.css";
import { RobotRow } from "./RobotRow";
import { TableBar } from "./TableBar";
import { TableHead, useColumns } from "./TableHead";
import { useRowWindow } from "./useRowWindow";
import { useSelection } from "./useSelection";

/** All robots, a row each; what is shown and in which order is in the page's address. */
export default function RobotTable({ robots }: { robots: readonly Robot[] }) {
  const alerts = useFleetTopic("alerts");
  const live = useFleetLive();
  const attentions = useMemo(() => attentionOf(alerts), [alerts]);
  const [view, change] = useAddress(overviewView);
  const naming = useNaming();
  const grouped = useMemo(() => naming.groups().length > 0, [naming]);
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
              onClick={() => change({ show: "all", text: "", group: null, site: null })}
            >
              Show all {robots.length}
            </Button>
          </div>
        )}
      </Paper>
    </>
  );
}

/** Takes the room of the rows that are not rendered. */
function Gap({ height }: { height: number }) {
  if (height === 0) return null;
  // biome-ignore lint/a11y/noAriaHiddenOnFocusable: a row without cells cannot have the focus
  return <tr aria-hidden="true" className={classes.gap} style={{ height }} />;
}

interface FiltersProps {
  robots: readonly Robot[];
  attentions: Attentions;
  view: View;
  onChange: (change: Partial<View>) => void;
}

/** How many robots there are of each kind, to read at a glance; pressed, the list shows those alone. */
function Filters({ robots, attentions, view, onChange }: FiltersProps) {
  const counts = useMemo(
    () => SHOWS.map((show) => robots.filter((robot) => matches(robot, show, attentions)).length),
    [robots, attentions],
  );
  const sites = useMemo(() => [...new Set(robots.map(siteOf))].sort(byName), [robots]);
  return (
    <div className={classes.filters}>
      <fieldset className={classes.shows}>
        <legend className={classes.legend}>Show robots</legend>
        {SHOWS.map((show, index) => (
          <button
            key={show}
            type="button"
            className={classes.show}
            aria-pressed={view.show === show}
            data-none={counts[index] === 0 || undefined}
            onClick={() => onChange({ show: view.show === show ? "all" : show })}
          >
            <span className={classes.number}>{counts[index]}</span> {SHOW_WORDS[show]}
          </button>
        ))}
      </fieldset>
      <div className={classes.choices}>
        {sites.length > 1 && (
          <NativeSelect
            className={classes.group ?? ""}
            aria-label="Site"
            value={view.site ?? ""}
            onChange={(event) => onChange({ site: event.currentTarget.value || null })}
            data={[{ value: "", label: "All sites" }, ...sites]}
          />
        )}
        <GroupSelect
          className={classes.group ?? ""}
          aria-label="Group"
          group={view.group}
          onGroup={(group) => onChange({ group })}
        />
        <Search text={view.text} onText={(text) => onChange({ text })} />
      </div>
    </div>
  );
}

/** Shows at once what is typed; the address, which follows, may be a few letters behind. */
function Search({ text, onText }: { text: string; onText: (text: string) => void }) {
  const [typed, setTyped] = useState<string | null>(null);
  return (
    <TextInput
      type="search"
      className={classes.search ?? ""}
      aria-label="Search robots by name or group"
      placeholder="Name or group"
      value={typed ?? text}
      onChange={(event) => {
        setTyped(event.currentTarget.value);
        onText(event.currentTarget.value);
      }}
      onBlur={() => setTyped(null)}
    />
  );
}
