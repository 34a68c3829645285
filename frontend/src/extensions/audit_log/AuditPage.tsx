import { Badge, Button, Group, Skeleton, Stack, Table, Text } from "@mantine/core";
import { Link } from "react-router";
import { useForbidden } from "../../api/session";
import { apiAddress } from "../../api/site";
import { useFleet, useNaming } from "../../fleet/context";
import { goalPath } from "../../fleet/names";
import { codeWords } from "../../goal/words";
import { useAddress } from "../../ui/address";
import { Command } from "../../ui/CopyButton";
import { Downloads } from "../../ui/Downloads";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { Breakable } from "../../ui/Fact";
import { type PagedList, usePages } from "../../ui/requests";
import { PageTitle } from "../../ui/Section";
import { Time } from "../../ui/Time";
import { useZone } from "../../ui/zone";
import { AuditFilters } from "./AuditFilters";
import classes from "./audit.module.css";
import type { AuditFilter } from "./filter";
import { auditFilter, GOAL_ID, OUTCOME_WORDS, type Outcome, toQuery, whatWords } from "./filter";
import { type AuditRecord, type AuditPage as AuditRecords, auditExportUrl, listAudit } from "./requests";

/** Who did what, from where, to which robot, with which outcome; for admins. */
export default function AuditPage() {
  const forbidden = useForbidden("GET /audit");
  const { store } = useFleet();
  const [filter, change] = useAddress(auditFilter);
  const list = useRecords(filter);
  return (
    <Stack gap="md">
      <PageTitle title="Audit" help="extensions/audit_log#on-the-dashboard">
        {forbidden === null && (
          <Group gap="xs">
            <Button variant="default" size="compact-sm" disabled={list.loading} onClick={list.refetch}>
              Refresh
            </Button>
            <Downloads
              what="these records"
              url={(format) => auditExportUrl(toQuery(filter, store.gatewayNow()), format)}
            />
          </Group>
        )}
      </PageTitle>
      {forbidden !== null ? (
        <Text size="sm">{forbidden}</Text>
      ) : (
        <>
          <Text size="sm" maw="44rem">
            Every request and command that changes something, whether it was carried out or refused. Exports
            and reading this page are recorded, too.
          </Text>
          <AuditFilters filter={filter} change={change} />
          <Trouble what="The audit log could not be loaded" error={list.error} onRetry={list.refetch} />
          <Listed
            list={list}
            filtered={!auditFilter.isInitial(filter)}
            onClear={() => change(auditFilter.initial)}
          />
        </>
      )}
    </Stack>
  );
}

/** The records that fit. They are loaded only when asked for, as reading them is recorded, too. */
function useRecords(filter: AuditFilter): PagedList<AuditRecords> {
  const { http, store } = useFleet();
  const zone = useZone();
  return usePages<AuditRecords, string>({
    queryKey: ["audit", zone, auditFilter.write(filter).toString()],
    queryFn: (cursor) => listAudit(http, toQuery(filter, store.gatewayNow()), cursor),
    enabled: useForbidden("GET /audit") === null,
  });
}

interface ListedProps {
  list: PagedList<AuditRecords>;
  filtered: boolean;
  onClear: () => void;
}

function Listed({ list, filtered, onClear }: ListedProps) {
  const { pages, error, loading, more, loadMore } = list;
  if (pages === undefined)
    return error === null && <Skeleton height={200} role="status" aria-label="The records are loading" />;
  const records = pages.flatMap((page) => page.records);
  if (records.length === 0) return <NoRecords filtered={filtered} onClear={onClear} />;
  return (
    <Stack gap="sm">
      <Text size="sm" c="dimmed" role="status">
        {more
          ? `The newest ${records.length} records`
          : records.length === 1
            ? "One record"
            : `${records.length} records`}
      </Text>
      <AuditTable records={records} />
      {more && (
        <Button variant="default" disabled={loading} onClick={loadMore}>
          Load older records
        </Button>
      )}
    </Stack>
  );
}

function NoRecords({ filtered, onClear }: Omit<ListedProps, "list">) {
  if (filtered) {
    return (
      <Empty
        title="No record fits"
        examples={
          <Button variant="default" onClick={onClear}>
            Show all records
          </Button>
        }
      >
        Choose a longer time, or fewer filters.
      </Empty>
    );
  }
  return (
    <Empty
      title="No records yet"
      examples={<Command line={`curl -s ${apiAddress()}/audit`} what="the command that lists the records" />}
    >
      The first command, such as Dock or Stop, is recorded here. The same list in a terminal:
    </Empty>
  );
}

const COLORS: Record<Outcome, string> = { done: "gray", refused: "orange", failed: "red" };

/** Records, a row each. */
function AuditTable({ records }: { records: readonly AuditRecord[] }) {
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.table ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Time</Table.Th>
          <Table.Th>Who</Table.Th>
          <Table.Th>What</Table.Th>
          <Table.Th visibleFrom="sm">About</Table.Th>
          <Table.Th>Outcome</Table.Th>
          <Table.Th visibleFrom="md">From</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {records.map((record) => (
          <Table.Tr key={record.sequence}>
            <Table.Td className={classes.time}>
              <Time value={record.acted_at} />
            </Table.Td>
            <Table.Td className={classes.name}>
              <Who record={record} />
            </Table.Td>
            <Table.Td title={record.what}>
              {whatWords(record.what)}
              <Text size="sm" component="div" hiddenFrom="sm">
                <About record={record} />
              </Text>
            </Table.Td>
            <Table.Td visibleFrom="sm" className={classes.name}>
              <About record={record} />
            </Table.Td>
            <Table.Td>
              <Badge variant="light" color={COLORS[record.outcome]} title={`Status ${record.status}`}>
                {OUTCOME_WORDS[record.outcome]}
              </Badge>
              {record.code !== null && <Text size="sm">{codeWords(record.code)}</Text>}
            </Table.Td>
            <Table.Td visibleFrom="md" className={classes.name}>
              {record.client}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Who({ record: { principal, role } }: { record: AuditRecord }) {
  if (principal === null) return <Text size="sm">{role === null ? "Unknown" : "Anyone (no token)"}</Text>;
  return (
    <>
      <Text size="sm" fw={600}>
        {principal}
      </Text>
      <Text size="sm">{role}</Text>
    </>
  );
}

/** Which robot, goal or thing. */
function About({ record: { robot, goal_id, action_name, subject } }: { record: AuditRecord }) {
  const naming = useNaming();
  return (
    <>
      {robot?.split(",").map((name) => (
        <div key={name}>{naming.fullNameOf(name)}</div>
      ))}
      {action_name !== null && <Breakable text={action_name} />}
      {goal_id !== null && GOAL_ID.test(goal_id) && (
        <div>
          <Link to={goalPath(goal_id, null)}>Goal {goal_id.slice(0, 8)}</Link>
        </div>
      )}
      {subject !== null && <div className={classes.subject}>{subject}</div>}
    </>
  );
}
