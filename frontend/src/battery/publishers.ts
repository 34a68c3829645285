import { useQuery } from "@tanstack/react-query";
import { findTopic, type GraphTopic, gatewayNode } from "../api/graph";
import { useFleet, useFleetPart } from "../fleet/context";
import { useLive, useServices, useTopicPart } from "../store/context";

/** The graph is asked again so often. */
const RENEW_MS = 5000;

export interface Publishers {
  topic: string;
  /** Neither this gateway nor a simulator: battery drivers, and `ros2 topic pub`. */
  others: string[];
  /** The simulator's, where it is one. */
  simulators: string[];
}

/** Who can publish on the battery's topic, by the names of their nodes. */
export function whoPublishes(topic: GraphTopic, gateway: string | null, simulated: boolean): Publishers {
  const names = topic.publishers.map(({ node }) => node).filter((node) => node !== gateway || node === null);
  const isSimulator = (node: string | null) => simulated && node?.endsWith("/dock_simulator") === true;
  return {
    topic: topic.name,
    others: distinct(names.filter((node) => !isSimulator(node)).map(describeNode)),
    simulators: distinct(names.filter(isSimulator).map(describeNode)),
  };
}

function describeNode(node: string | null): string {
  if (node === null) return "a DDS program that is no ROS node";
  return /\/_ros2cli_\d+$/.test(node) ? "ros2 topic pub" : node;
}

function distinct(names: readonly string[]): string[] {
  return [...new Set(names)].sort();
}

/** Who can publish this robot's battery now; null as long as nobody knows. */
export function usePublishers(): Publishers | null {
  const { http } = useFleet();
  const { robot } = useServices();
  const live = useLive();
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const name = useFleetPart(
    "robots",
    (robots) =>
      [...robots.values()].find((each) => (robot === null ? each.default : each.name === robot))
        ?.battery_topic,
  );
  const own = useQuery({
    queryKey: ["gateway-node"],
    queryFn: () => gatewayNode(http),
    enabled: live,
    staleTime: Number.POSITIVE_INFINITY,
  });
  const topic = useQuery({
    queryKey: ["topic", name],
    queryFn: () => findTopic(http, name ?? ""),
    enabled: live && name !== undefined,
    refetchInterval: RENEW_MS,
  });
  if (!live || topic.data === undefined || own.data === undefined) return null;
  return whoPublishes(topic.data, own.data, simulated);
}
