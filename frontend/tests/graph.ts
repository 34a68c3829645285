import type { Endpoint, Graph, GraphNode, GraphTopic, Quality } from "../src/api/graph";

export function quality(change: Partial<Quality> = {}): Quality {
  return {
    reliability: "reliable",
    durability: "volatile",
    history: "unknown",
    depth: null,
    deadline_s: null,
    lifespan_s: null,
    liveliness: "automatic",
    ...change,
  };
}

export function endpoint(node: string | null, change: Partial<Quality> = {}): Endpoint {
  return { node, qos: quality(change) };
}

export function topic(name: string, change: Partial<GraphTopic> = {}): GraphTopic {
  return { name, types: ["std_msgs/msg/String"], publishers: [], subscribers: [], hidden: false, ...change };
}

export function node(name: string, change: Partial<GraphNode> = {}): GraphNode {
  return {
    name,
    count: 1,
    publishers: [],
    subscribers: [],
    services: [],
    clients: [],
    action_servers: [],
    action_clients: [],
    hidden: false,
    ...change,
  };
}

/** Two robots, each with a server that hears its battery, a gateway at all of it, and ROS's noise. */
export function fleetGraph(): Graph {
  const robots = ["/robot1", "/robot2"];
  return {
    nodes: [
      node("/dock_gateway", {
        publishers: ["/rosout", "/stop_latched"],
        subscribers: robots.map((robot) => `${robot}/battery_status`),
        action_clients: robots.map((robot) => `${robot}/connect_to_charging_dock`),
      }),
      node("/fleet_manager", { clients: ["/robot1/reset"] }),
      ...robots.flatMap((robot) => [
        node(`${robot}/battery`, { publishers: [`${robot}/battery_status`, "/rosout"] }),
        node(`${robot}/docking_server`, {
          subscribers: [`${robot}/battery_status`],
          services: [`${robot}/reset`, `${robot}/docking_server/get_parameters`],
          action_servers: [`${robot}/connect_to_charging_dock`],
        }),
      ]),
    ],
    topics: [
      ...robots.map((robot) =>
        topic(`${robot}/battery_status`, {
          types: ["sensor_msgs/msg/BatteryState"],
          publishers: [endpoint(`${robot}/battery`)],
          subscribers: [endpoint(`${robot}/docking_server`), endpoint("/dock_gateway")],
        }),
      ),
      topic("/rosout", {
        publishers: [endpoint("/dock_gateway"), ...robots.map((robot) => endpoint(`${robot}/battery`))],
        hidden: true,
      }),
      topic("/stop_latched", { publishers: [endpoint("/dock_gateway")] }),
    ],
    services: robots.flatMap((robot) => [
      {
        name: `${robot}/reset`,
        types: ["std_srvs/srv/Empty"],
        servers: [`${robot}/docking_server`],
        hidden: false,
      },
      {
        name: `${robot}/docking_server/get_parameters`,
        types: ["rcl_interfaces/srv/GetParameters"],
        servers: [`${robot}/docking_server`],
        hidden: true,
      },
    ]),
    actions: robots.map((robot) => ({
      name: `${robot}/connect_to_charging_dock`,
      types: ["action_tutorials_interfaces/action/ConnectToChargingDock"],
      servers: [`${robot}/docking_server`],
      clients: ["/dock_gateway"],
      hidden: false,
    })),
  };
}
