import { useCallback, useMemo, useRef } from "react";
import { useSearchParams } from "react-router";
import { parseThing, type Thing, thingId } from "./things";

/** What the picture shows besides nodes, as in rqt_graph. */
export const SHOWN = ["nodes", "topics", "all"] as const;

/** Nodes only; nodes and topics; nodes, topics and actions. */
export type Shown = (typeof SHOWN)[number];

export type Form = "picture" | "list";

/** What the page shows of the graph. All of it stands in the page's address. */
export interface GraphView {
  /** Null: as it suits the screen. */
  form: Form | null;
  shown: Shown;
  /** `/` for all of them. */
  namespace: string;
  search: string;
  /** What is not shown unless it is asked for. */
  hidden: boolean;
  services: boolean;
  gateway: boolean;
  selected: Thing | null;
  /** Whether the messages of the selected topic are shown. */
  echo: boolean;
}

export const DEFAULT_VIEW: GraphView = {
  form: null,
  shown: "all",
  namespace: "/",
  search: "",
  hidden: false,
  services: false,
  gateway: false,
  selected: null,
  echo: false,
};

export function readView(query: URLSearchParams): GraphView {
  const form = query.get("view");
  const namespace = query.get("namespace");
  return {
    form: form === "picture" || form === "list" ? form : null,
    shown: SHOWN.find((shown) => shown === query.get("show")) ?? "all",
    namespace: namespace?.startsWith("/") ? namespace : "/",
    search: query.get("search") ?? "",
    hidden: query.get("hidden") === "true",
    services: query.get("services") === "true",
    gateway: query.get("gateway") === "true",
    selected: parseThing(query.get("selected")),
    echo: query.get("echo") === "true",
  };
}

/** The view as a query; what is as usual is left out. */
export function writeView(view: GraphView): URLSearchParams {
  const entries: [string, string | null][] = [
    ["view", view.form],
    ["show", view.shown === "all" ? null : view.shown],
    ["namespace", view.namespace === "/" ? null : view.namespace],
    ["search", view.search],
    ["hidden", view.hidden ? "true" : null],
    ["services", view.services ? "true" : null],
    ["gateway", view.gateway ? "true" : null],
    ["selected", view.selected && thingId(view.selected)],
    ["echo", view.echo ? "true" : null],
  ];
  return new URLSearchParams(
    entries.flatMap(([name, value]): [string, string][] => (value ? [[name, value]] : [])),
  );
}

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
