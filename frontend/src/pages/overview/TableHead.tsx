import { Checkbox, Table, VisuallyHidden } from "@mantine/core";
import { COLUMNS, type Column } from "./columns";
import type { Sort, View } from "./list";
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
