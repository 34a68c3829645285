import type { ClientError } from "@dock-gateway/client";
import {
  keepPreviousData,
  type QueryFunctionContext,
  type UseMutationResult,
  type UseQueryOptions,
  type UseQueryResult,
  useInfiniteQuery,
  useMutation,
  useQuery,
} from "@tanstack/react-query";
import { useCallback } from "react";
import { toClientError } from "../api/errors";

function failing(error: unknown): never {
  throw toClientError(error);
}

/** A command to the gateway, sent once for each call and never again by itself. */
export function useCommand<Result, Input = void>(
  send: (input: Input) => Promise<Result>,
): UseMutationResult<Result, ClientError, Input> {
  return useMutation<Result, ClientError, Input>({
    // By default a mutation made while the browser is offline waits, and is sent when it is back.
    networkMode: "always",
    retry: false,
    mutationFn: (input) => send(input).catch(failing),
  });
}

interface AnswerOptions<Answer, Shown> extends Omit<UseQueryOptions<Answer, ClientError, Shown>, "queryFn"> {
  queryFn: (context: QueryFunctionContext) => Promise<Answer>;
}

/** What the gateway answers to a request; every failure is a ClientError. */
export function useAnswer<Answer, Shown = Answer>({
  queryFn,
  ...options
}: AnswerOptions<Answer, Shown>): UseQueryResult<Shown, ClientError> {
  return useQuery<Answer, ClientError, Shown>({
    ...options,
    queryFn: (context) => queryFn(context).catch(failing),
  });
}

/** A list that the gateway answers page by page. */
export interface PagedList<Page> {
  /** Undefined until the first page has come. */
  pages: readonly Page[] | undefined;
  error: ClientError | null;
  /** Whether there are more pages. */
  more: boolean;
  loading: boolean;
  loadMore: () => void;
  refetch: () => void;
}

interface PagesOptions<Page, Cursor> {
  queryKey: readonly string[];
  queryFn: (cursor: Cursor | null) => Promise<Page>;
  enabled?: boolean;
  /** Between two requests for all pages, by their number (ms); without it they are asked for once. */
  refetchMs?: (pages: number) => number;
  /** Whether the pages of the key before are shown until those of another one have come. */
  keepPrevious?: boolean;
}

/** The pages of a list; every failure is a ClientError. */
export function usePages<Page extends { next_cursor: Cursor | null }, Cursor>(
  options: PagesOptions<Page, Cursor>,
): PagedList<Page> {
  const { queryKey, queryFn, enabled = true, refetchMs, keepPrevious = false } = options;
  const query = useInfiniteQuery<Page, ClientError, { pages: Page[] }, readonly string[], Cursor | null>({
    queryKey,
    queryFn: ({ pageParam }) => queryFn(pageParam as Cursor | null).catch(failing),
    initialPageParam: null,
    getNextPageParam: (page) => page.next_cursor,
    enabled,
    refetchOnReconnect: refetchMs !== undefined,
    refetchInterval: ({ state }) => refetchMs?.(state.data?.pages.length ?? 1) ?? false,
    ...(keepPrevious ? { placeholderData: keepPreviousData } : {}),
  });
  const { data, error, hasNextPage, isPlaceholderData, isFetching, fetchNextPage, refetch } = query;
  return {
    pages: data?.pages,
    error,
    more: hasNextPage && !isPlaceholderData,
    loading: isFetching,
    loadMore: () => void fetchNextPage(),
    refetch: useCallback(() => void refetch(), [refetch]),
  };
}
