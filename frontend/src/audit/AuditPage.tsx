import { Button, Group, Skeleton, Stack, Text } from "@mantine/core";
import { useMemo } from "react";
import { useSearchParams } from "react-router";
import { auditExportUrl } from "../api/audit";
import { useForbidden } from "../api/permissions";
import { useFleet } from "../fleet/context";
import { Downloads } from "../ui/Downloads";
import { Trouble } from "../ui/errors";
import { PageTitle } from "../ui/PageTitle";
import { AuditFilters } from "./AuditFilters";
import { AuditTable } from "./AuditTable";
import { readFilter, toQuery, writeFilter } from "./filter";
import { type AuditList, useAudit } from "./useAudit";

/** Who did what, from where, to which robot, with which outcome; for admins. */
export default function AuditPage() {
  const forbidden = useForbidden("GET /audit");
  const { store } = useFleet();
  const [parameters, setParameters] = useSearchParams();
  const filter = useMemo(() => readFilter(parameters), [parameters]);
  const list = useAudit(filter);
  return (
    <Stack gap="md">
      <PageTitle title="Audit">
        {forbidden === null && (
          <Group gap="xs">
            <Button variant="default" size="compact-sm" disabled={list.loading} onClick={list.refresh}>
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
          <AuditFilters
            filter={filter}
            onChange={(next) => setParameters(writeFilter(next), { replace: true })}
          />
          <Trouble what="The audit log could not be loaded" error={list.error} onRetry={list.refresh} />
          <Listed list={list} />
        </>
      )}
    </Stack>
  );
}

function Listed({ list }: { list: AuditList }) {
  const { records, error, loading, more, loadMore } = list;
  if (records === null)
    return error === null && <Skeleton height={200} role="status" aria-label="The records are loading" />;
  if (records.length === 0) return <Text size="sm">No record fits.</Text>;
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
