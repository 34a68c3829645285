import { type UseQueryResult, useQuery, useQueryClient } from "@tanstack/react-query";
import type { CommandError } from "../api/errors";
import { type Graph, gatewayNode, readGraph, type TaggedGraph } from "../api/graph";
import { useFleet } from "../fleet/context";
import { useAnswer } from "../ui/requests";

const INTERVAL_MS = 2000;
const KEY = ["graph"];

/** The ROS graph, asked for every two seconds while the page is looked at; the same object until it changes. */
export function useGraph(): UseQueryResult<Graph, CommandError> {
  const { http } = useFleet();
  const client = useQueryClient();
  return useAnswer({
    queryKey: KEY,
    queryFn: () => readGraph(http, client.getQueryData<TaggedGraph>(KEY)),
    select: graphOf,
    refetchInterval: INTERVAL_MS,
  });
}

function graphOf({ graph }: TaggedGraph): Graph {
  return graph;
}

/** The gateway's node: the name that it has by default until it has told. */
export function useGatewayNode(): string {
  const { http } = useFleet();
  const { data } = useQuery({
    queryKey: ["gateway-node"],
    queryFn: () => gatewayNode(http),
    staleTime: Number.POSITIVE_INFINITY,
  });
  return data ?? "/dock_gateway";
}
