import { Badge, Button, Group, Table, Text } from "@mantine/core";
import { type ReactNode, useMemo, useState } from "react";
import type { Graph, GraphNode } from "../api/graph";
import { Section } from "../ui/Section";
import { clientsOf } from "./filter";
import classes from "./graph.module.css";
import { ThingLink } from "./names";
import { warningOf } from "./qos";
import { KINDS, type Kind, type Thing } from "./things";
import type { ChangeView } from "./view";
import { KIND_NAMES } from "./words";

const PAGE = 50;

interface GraphListProps {
  graph: Graph;
  /** All nodes, also those that are not shown. */
  nodes: readonly GraphNode[];
  selected: Thing | null;
  change: ChangeView;
}

interface Row {
  name: string;
  types: string[];
  warning: string | null;
  /** The numbers of a row, one for each column of this kind. */
  counts: number[];
}

const COLUMNS: Record<Kind, [string, string]> = {
  node: ["Publishes", "Subscribes"],
  topic: ["Publishers", "Subscribers"],
  action: ["Servers", "Clients"],
  service: ["Servers", "Clients"],
};

/** The graph in words. */
export function GraphList({ graph, nodes, selected, change }: GraphListProps) {
  const rows = useMemo(() => rowsOf(graph, nodes), [graph, nodes]);
  const kinds = KINDS.filter((kind) => rows[kind].length > 0);
  if (kinds.length === 0) return <Text c="dimmed">Nothing matches the search.</Text>;
  return (
    <div className={classes.list}>
      {kinds.map((kind) => (
        <Section
          key={kind}
          title={KIND_NAMES[kind]}
          aside={
            <Text size="sm" c="dimmed" className="tabular">
              {rows[kind].length}
            </Text>
          }
        >
          <ThingTable kind={kind} rows={rows[kind]} selected={selected} change={change} />
        </Section>
      ))}
    </div>
  );
}

function rowsOf(graph: Graph, nodes: readonly GraphNode[]): Record<Kind, Row[]> {
  const clients = clientsOf(nodes);
  return {
    node: graph.nodes.map(({ name, count, publishers, subscribers }) => ({
      name,
      types: [],
      warning: count > 1 ? `${count} of this name` : null,
      counts: [publishers.length, subscribers.length],
    })),
    topic: graph.topics.map((topic) => ({
      name: topic.name,
      types: topic.types,
      warning: warningOf(topic),
      counts: [topic.publishers.length, topic.subscribers.length],
    })),
    action: graph.actions.map(({ name, types, servers, clients }) => ({
      name,
      types,
      warning: null,
      counts: [servers.length, clients.length],
    })),
    service: graph.services.map(({ name, types, servers }) => ({
      name,
      types,
      warning: null,
      counts: [servers.length, clients.get(name)?.length ?? 0],
    })),
  };
}

interface ThingTableProps {
  kind: Kind;
  rows: readonly Row[];
  selected: Thing | null;
  change: ChangeView;
}

function ThingTable({ kind, rows, selected, change }: ThingTableProps) {
  const [shown, setShown] = useState(PAGE);
  const more = rows.length - shown;
  return (
    <>
      <Table verticalSpacing={6} horizontalSpacing={8} layout="fixed">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Name</Table.Th>
            {kind !== "node" && <Table.Th visibleFrom="sm">Type</Table.Th>}
            {COLUMNS[kind].map((column) => (
              <NumberHead key={column}>{column}</NumberHead>
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {rows.slice(0, shown).map(({ name, types, warning, counts }) => (
            <Table.Tr key={name}>
              <Table.Td className={classes.wrap}>
                <Group gap="xs">
                  <ThingLink
                    kind={kind}
                    name={name}
                    change={change}
                    current={selected?.kind === kind && selected.name === name}
                  />
                  {warning !== null && <Badge color="orange">{warning}</Badge>}
                </Group>
              </Table.Td>
              {kind !== "node" && (
                <Table.Td visibleFrom="sm" className={classes.wrap}>
                  {types.join(", ")}
                </Table.Td>
              )}
              {counts.map((count, index) => (
                <Table.Td key={COLUMNS[kind][index]} ta="right" className="tabular">
                  {count}
                </Table.Td>
              ))}
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
      {more > 0 && (
        <Button variant="default" onClick={() => setShown(rows.length)}>
          Show {more} more
        </Button>
      )}
    </>
  );
}

function NumberHead({ children }: { children: ReactNode }) {
  return (
    <Table.Th ta="right" className={classes.number}>
      {children}
    </Table.Th>
  );
}
