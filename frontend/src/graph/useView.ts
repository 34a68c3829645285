import { useCallback, useMemo, useRef } from "react";
import { useSearchParams } from "react-router";
import { type GraphView, readView, writeView } from "./view";

export type ChangeView = (change: Partial<GraphView>) => void;

/** What the address says is shown, and the way to change it. Another selection is a step that Back takes back. */
export function useView(): [GraphView, ChangeView] {
  const [query, setQuery] = useSearchParams();
  const view = useMemo(() => readView(query), [query]);
  const latest = useRef({ view, setQuery });
  latest.current = { view, setQuery };
  const change = useCallback<ChangeView>((part) => {
    latest.current.view = { ...latest.current.view, ...part };
    latest.current.setQuery(writeView(latest.current.view), { replace: !("selected" in part) });
  }, []);
  return [view, change];
}
