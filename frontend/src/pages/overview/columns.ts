import { useLocalStorage } from "@mantine/hooks";
import { useMemo } from "react";
import { readColumns, type Sort } from "./list";

export interface Column {
  sort: Sort;
  name: string;
  /** Left out where the window is narrow: the robot's own cell says it there. */
  wide?: boolean;
}

export const COLUMNS: readonly Column[] = [
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
  /** Those that are shown. */
  shown: ReadonlySet<Sort>;
  /** Those that can be hidden, in the order of the table. */
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
