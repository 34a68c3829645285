import { Checkbox, Table, VisuallyHidden } from "@mantine/core";
import { useLocalStorage } from "@mantine/hooks";
import { useMemo } from "react";
import { readColumns, type Sort, type View } from "./list";
import classes from "./overview.module.css";
import type { Selection } from "./useSelection";

interface TableHeadProps {
  shown: ReadonlySet<Sort>;
  view: View;
  selection: Selection;
  /** How many robots are listed. */
  listed: number;
  onSort: (change: Partial<View>) => void;
}

/** The columns' names, which sort, and a checkbox for all that are listed. */
export function TableHead({ shown, view, selection, listed, onSort }: TableHeadProps) {
  const count = selection.names.length;
  const all = count > 0 && count === listed;
  return (
    <Table.Thead className={classes.head}>
      <Table.Tr aria-rowindex={1}>
        <Table.Th scope="col" className={classes.selectCell}>
          <Checkbox
            size="xs"
            aria-label={`Select all ${listed} that are listed`}
            checked={all}
            indeterminate={count > 0 && !all}
            disabled={listed === 0}
            onChange={all ? selection.none : selection.all}
          />
        </Table.Th>
        {COLUMNS.filter(({ sort }) => shown.has(sort)).map((column) => (
          <HeaderCell key={column.sort} column={column} view={view} onSort={onSort} />
        ))}
        <Table.Th scope="col" className={classes.menuCell}>
          <VisuallyHidden>Commands</VisuallyHidden>
        </Table.Th>
      </Table.Tr>
    </Table.Thead>
  );
}

interface HeaderCellProps {
  column: Column;
  view: View;
  onSort: (change: Partial<View>) => void;
}

/** Sorts ascending, descending, and then no more: by name. */
function HeaderCell({ column: { sort, name, wide = false }, view, onSort }: HeaderCellProps) {
  const sorted = view.sort === sort;
  const direction = !sorted ? "none" : view.descending ? "descending" : "ascending";
  const press = () => {
    if (!sorted) onSort({ sort, descending: false });
    else if (!view.descending) onSort({ descending: true });
    else onSort({ sort: "name", descending: false });
  };
  return (
    <Table.Th
      scope="col"
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

const KEY = "dock-gateway-overview-columns";

export interface ColumnChoice {
  /** The columns that are shown. */
  shown: ReadonlySet<Sort>;
  /** The columns that can be hidden, in the order of the table. */
  optional: readonly Column[];
  hidden: readonly Sort[];
  toggle: (sort: Sort) => void;
}

/**
 * Which columns are shown.
 *
 * @param grouped Whether a robot is in a group.
 * @param inAddress Those that the address hides; null for the choice that is kept in this browser.
 * @param onHide Hides other ones in the address.
 */
export function useColumns(
  grouped: boolean,
  inAddress: readonly Sort[] | null,
  onHide: (hidden: Sort[]) => void,
): ColumnChoice {
  const [kept, keep] = useLocalStorage<unknown>({
    key: KEY,
    defaultValue: [],
    getInitialValueInEffect: false,
  });
  const hidden = useMemo(() => inAddress ?? readColumns(kept), [inAddress, kept]);
  const choice = useMemo(() => {
    const there = COLUMNS.filter(({ sort }) => grouped || sort !== "groups");
    const shown = there.filter(({ sort }) => sort === "name" || !hidden.includes(sort));
    return {
      shown: new Set(shown.map(({ sort }) => sort)),
      optional: there.filter(({ sort }) => sort !== "name"),
      hidden,
    };
  }, [grouped, hidden]);
  const toggle = (sort: Sort) => {
    const next = hidden.includes(sort) ? hidden.filter((each) => each !== sort) : [...hidden, sort];
    if (inAddress === null) keep(next);
    else onHide(readColumns(next));
  };
  return { ...choice, toggle };
}
