import { CloseButton, Group, NativeSelect, SegmentedControl, Switch, TextInput } from "@mantine/core";
import { useMemo, useState } from "react";
import type { Graph } from "../api/graph";
import { namespacesOf } from "./filter";
import classes from "./graph.module.css";
import { type ChangeView, type Form, type GraphView, SHOWN, type Shown } from "./view";

const SHOWN_LABELS: Record<Shown, string> = {
  nodes: "Nodes only",
  topics: "With topics",
  all: "With actions",
};

interface GraphFiltersProps {
  graph: Graph | undefined;
  form: Form;
  view: GraphView;
  change: ChangeView;
}

/** What of the graph is shown. */
export function GraphFilters({ graph, form, view, change }: GraphFiltersProps) {
  const namespaces = useMemo(() => (graph === undefined ? ["/"] : namespacesOf(graph)), [graph]);
  // One that has gone, or that somebody's link names, stays to be seen.
  const options = namespaces.includes(view.namespace) ? namespaces : [...namespaces, view.namespace];

  return (
    <search className={classes.filters} aria-label="What is shown">
      <SearchField value={view.search} onChange={(search) => change({ search })} />
      <NativeSelect
        aria-label="Namespace"
        value={view.namespace}
        onChange={(event) => change({ namespace: event.currentTarget.value })}
        data={options.map((value) => ({ value, label: value === "/" ? "All namespaces" : value }))}
      />
      {form === "picture" && (
        <SegmentedControl
          aria-label="In the picture"
          data={SHOWN.map((value) => ({ value, label: SHOWN_LABELS[value] }))}
          value={view.shown}
          onChange={(value) => change({ shown: SHOWN.find((shown) => shown === value) ?? "all" })}
        />
      )}
      <Group gap="md">
        <Switch
          label="Hidden topics"
          checked={view.hidden}
          onChange={(event) => change({ hidden: event.currentTarget.checked })}
        />
        <Switch
          label="Services"
          checked={view.services}
          onChange={(event) => change({ services: event.currentTarget.checked })}
        />
        <Switch
          label="The gateway"
          checked={view.gateway}
          onChange={(event) => change({ gateway: event.currentTarget.checked })}
        />
      </Group>
    </search>
  );
}

/** Keeps what is typed to itself until it is left: the address follows a moment later. */
function SearchField({ value, onChange }: { value: string; onChange: (value: string) => void }) {
  const [typed, setTyped] = useState<string | null>(null);
  const shown = typed ?? value;
  return (
    <TextInput
      type="search"
      className={classes.search}
      aria-label="Search by name or type"
      placeholder="Search by name or type"
      value={shown}
      onChange={(event) => {
        setTyped(event.currentTarget.value);
        onChange(event.currentTarget.value);
      }}
      onBlur={() => setTyped(null)}
      rightSection={
        shown !== "" && (
          <CloseButton
            size="sm"
            aria-label="Clear the search"
            onClick={() => {
              setTyped(null);
              onChange("");
            }}
          />
        )
      }
    />
  );
}
