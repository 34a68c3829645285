import { useLocalStorage } from "@mantine/hooks";
import { useMemo } from "react";
import type { Sort } from "./list";

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
  toggle: (sort: Sort) => void;
}

/** Which columns are shown, as was chosen in this browser. @param grouped Whether a robot is in a group. */
export function useColumns(grouped: boolean): ColumnChoice {
  const [hidden, setHidden] = useLocalStorage<readonly string[]>({
    key: KEY,
    defaultValue: [],
    getInitialValueInEffect: false,
  });
  return useMemo(() => {
    const there = COLUMNS.filter(({ sort }) => grouped || sort !== "groups");
    const optional = there.filter(({ sort }) => sort !== "name");
    const shown = there.filter(({ sort }) => sort === "name" || !hidden.includes(sort));
    return {
      shown: new Set(shown.map(({ sort }) => sort)),
      optional,
      toggle: (sort) =>
        setHidden((before) =>
          before.includes(sort) ? before.filter((each) => each !== sort) : [...before, sort],
        ),
    };
  }, [grouped, hidden, setHidden]);
}
