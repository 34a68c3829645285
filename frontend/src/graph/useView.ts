import { useCallback, useEffect, useRef, useState } from "react";
import { useSearchParams } from "react-router";
import { type GraphView, readView, writeView } from "./view";

export type ChangeView = (change: Partial<GraphView>) => void;

/**
 * What is shown, and the way to change it. It stands in the page's address too, which follows a moment later; another
 * selection is a step that Back takes back.
 */
export function useView(): [GraphView, ChangeView] {
  const [query, setQuery] = useSearchParams();
  const [view, setView] = useState(() => readView(query));
  const latest = useRef(view);
  const underWay = useRef(new Set<string>());
  const tell = useRef(setQuery);

  useEffect(() => {
    tell.current = setQuery;
    const text = query.toString();
    if (text === writeView(latest.current).toString()) {
      underWay.current.clear();
    } else if (!underWay.current.has(text)) {
      // Back, or a link.
      latest.current = readView(query);
      setView(latest.current);
    }
  }, [query, setQuery]);

  const change = useCallback<ChangeView>((part) => {
    latest.current = { ...latest.current, ...part };
    setView(latest.current);
    const next = writeView(latest.current);
    underWay.current.add(next.toString());
    tell.current(next, { replace: !("selected" in part) });
  }, []);
  return [view, change];
}
