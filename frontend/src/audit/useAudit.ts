import { useInfiniteQuery } from "@tanstack/react-query";
import { type CommandError, toCommandError } from "../api/errors";
import { type AuditPage, type AuditRecord, listAudit } from "../api/history";
import { useForbidden } from "../api/session";
import { useFleet } from "../fleet/context";
import { useZone } from "../ui/zone";
import { type AuditFilter, auditFilter, toQuery } from "./filter";

export interface AuditList {
  /** Newest first; null until the first page has come. */
  records: readonly AuditRecord[] | null;
  error: CommandError | null;
  /** Whether there are older ones. */
  more: boolean;
  loading: boolean;
  loadMore(): void;
  refresh(): void;
}

/** The records that fit. They are loaded only when asked for, as reading them is recorded, too. */
export function useAudit(filter: AuditFilter): AuditList {
  const { http, store } = useFleet();
  const zone = useZone();
  const forbidden = useForbidden("GET /audit");
  const query = useInfiniteQuery<
    AuditPage,
    CommandError,
    { pages: AuditPage[] },
    readonly string[],
    number | null
  >({
    queryKey: ["audit", zone, auditFilter.write(filter).toString()],
    queryFn: ({ pageParam }) =>
      listAudit(http, toQuery(filter, store.gatewayNow()), pageParam).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    initialPageParam: null,
    getNextPageParam: (page) => page.next_cursor,
    enabled: forbidden === null,
    refetchOnWindowFocus: false,
    refetchOnReconnect: false,
  });
  return {
    records: query.data?.pages.flatMap((page) => page.records) ?? null,
    error: query.error,
    more: query.hasNextPage,
    loading: query.isFetching,
    loadMore: () => void query.fetchNextPage(),
    refresh: () => void query.refetch(),
  };
}
