import type { Robot } from "@dock-gateway/client";
import { useCallback, useMemo, useRef, useState } from "react";
import { useLatest } from "../../ui/useLatest";

export interface Selection {
  /** The robots that are selected and listed, in the order of the list: nothing is done to one that cannot be seen. */
  names: readonly string[];
  has: (name: string) => boolean;
  /** Selects a robot, or no more. @param range All from the last one that was changed up to this one. */
  toggle: (name: string, range: boolean) => void;
  /** All that are listed. */
  all: () => void;
  none: () => void;
}

/** The robots of a list that are selected. */
export function useSelection(rows: readonly Robot[]): Selection {
  const [chosen, setChosen] = useState<ReadonlySet<string>>(new Set());
  const last = useRef<string | null>(null);
  const listed = useLatest(rows);

  const toggle = useCallback((name: string, range: boolean) => {
    const names = listed.current.map((robot) => robot.name);
    const from = range && last.current !== null ? names.indexOf(last.current) : -1;
    const to = names.indexOf(name);
    const changed = from < 0 ? [name] : names.slice(Math.min(from, to), Math.max(from, to) + 1);
    last.current = name;
    setChosen((before) => {
      const next = new Set(before);
      const selects = !before.has(name);
      for (const each of changed) selects ? next.add(each) : next.delete(each);
      return next;
    });
  }, []);
  const all = useCallback(() => setChosen(new Set(listed.current.map(({ name }) => name))), []);
  const none = useCallback(() => setChosen(new Set()), []);

  const names = useMemo(
    () => rows.filter(({ name }) => chosen.has(name)).map(({ name }) => name),
    [rows, chosen],
  );
  return { names, has: (name) => chosen.has(name), toggle, all, none };
}
