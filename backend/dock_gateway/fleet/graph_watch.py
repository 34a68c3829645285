"""Watches the ROS graph for faults around the robots, such as topics of another type than expected."""

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import lru_cache, partial
from itertools import islice
from typing import TypeVar

from dock_gateway.core.dock_adapters.catalog import ADAPTERS, MAX_ROBOTS
from dock_gateway.core.graph import ACTION_PART, STATUS, Peer, Topic
from dock_gateway.fleet.findings import (
    Expected,
    Finding,
    FindingKind,
    merge,
    seen_twice,
    two_bases,
    wrong_action,
    wrong_type,
)
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.registry import BATTERY_TYPE, RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import STOP_TYPE, Scan, count_publishers, count_subscribers, find_gateways, read_topic
from dock_gateway.ros.scene_port import SCENE_TYPES
from dock_gateway.settings import Settings
from robot_io.velocity_types import TYPES as VELOCITY_TYPES

DIAGNOSTICS_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
UNHEARD = "Messages there do not stop the robot."
# Seconds after which topics are read again although their types are the same.
READ_AGAIN_AFTER = 5.0
# Seconds after which a node counts as there: while a base restarts, the old one may still be on the graph.
SETTLED = 5.0
# The maximum number of topics that are read at one scan: a node may offer thousands of a wrong type.
MAX_READ = 50

# Topics that are read at a time on the ROS thread: a few milliseconds.
FEW = 20

T = TypeVar("T")
Suspect = tuple[str | None, str, Expected]


class GraphWatch:
    """Finds faults on the graph.

    Args:
        settings: Names.
        bridge: Runs calls on the ROS thread.
        robots: The robots.
        robot_actions: The docking actions.

    Attributes:
        findings: The current faults.
        shared: The robots whose docking action is served by a node that serves that of another robot, too.
    """

    def __init__(self, settings: Settings, bridge: Bridge, robots: RobotRegistry, robot_actions: RobotActions) -> None:
        self.findings: list[Finding] = []
        self.shared: frozenset[str] = frozenset()
        self._robot_actions = robot_actions
        self._doubles: list[Finding] = []
        self._looked_at: tuple[float, dict[str, str]] = (float("-inf"), {})
        self._since: dict[Peer, float] = {}  # when each node was first seen, on the monotonic clock
        self._settings = settings
        self._bridge = bridge
        self._robots = robots
        self._read: dict[str, tuple[frozenset[str], float, Topic, frozenset[str]]] = {}
        self._expected = lru_cache(MAX_ROBOTS)(self._expect)

    async def update(self, scan: Scan) -> None:
        """Look at the graph.

        Raises:
            Unavailable: The ROS thread is down.
        """
        found = [*await self._find_wrong_types(scan), *self._find_wrong_actions(scan)]
        docking = self._docking(scan)
        if docking != self._looked_at[1] or time.monotonic() - self._looked_at[0] > READ_AGAIN_AFTER:
            self._looked_at = time.monotonic(), docking
            self._doubles = [*await self._find_shared_servers(docking), *await self._find_bases()]
        self.findings = list(merge([*found, *self._doubles]))

    def remark(self, action_name: str) -> str:
        """Return the faults around the robot of an action that keep its goals from succeeding."""
        owner = self._robots.owner(action_name)
        return " ".join(
            each.detail
            for each in self.findings
            if owner is not None and each.robot == owner.namespace and each.kind is FindingKind.DUPLICATE_BASE
        )

    async def _find_wrong_types(self, scan: Scan) -> list[Finding]:
        found = []
        suspects = list(islice(self._suspects(scan), MAX_READ))
        self._read = {topic: self._read[topic] for _, topic, _ in suspects if topic in self._read}
        for robot, name, expected in suspects:
            topic, gateways = await self._read_topic(robot, name, frozenset(scan.topics[name]))
            if (finding := wrong_type(robot, topic, expected, gateways)) is not None:
                found.append(finding)
        return found

    def _find_wrong_actions(self, scan: Scan) -> Iterator[Finding]:
        """Yield the findings that actions are of another type than the settings say."""
        catalog = self._robot_actions.catalog
        for verb in ADAPTERS:
            wanted = catalog.preferred(verb)
            for robot in self._robots.all() if wanted.strict and wanted.configured else ():
                name = catalog.names(verb, robot.namespace)[0]
                types = scan.actions.get(name, [])
                if types and wanted.likely_type not in types:
                    yield wrong_action(robot.namespace, name, types, wanted.likely_type, verb)

    def _docking(self, scan: Scan) -> dict[str, str]:
        """Return the docking actions that have a server, by robot."""
        names = self._robots.namespaces()
        docking = ((robot, self._robot_actions.docking_pair(robot).dock) for robot in names)
        return {robot: action for robot, action in docking if action in scan.actions}

    async def _find_shared_servers(self, docking: Mapping[str, str]) -> list[Finding]:
        """Find the nodes that serve the docking actions of several robots."""
        found: dict[Peer, dict[str, str]] = defaultdict(dict)
        actions = set(docking.values()) if len(set(docking.values())) > 1 else set[str]()
        topics = await self._topics([f"{action}{ACTION_PART}{STATUS}" for action in actions])
        for robot, action in docking.items() if topics else ():
            for endpoint in topics[f"{action}{ACTION_PART}{STATUS}"].publishers:
                found[endpoint.peer][robot] = action
        shared = {node: robots for (node, _), robots in found.items() if node and len(set(robots.values())) > 1}
        if self._settings.allow_shared_servers:
            shared = {}
        self.shared = frozenset(robot for robots in shared.values() for robot in robots)
        return [seen_twice(robots, node) for node, robots in shared.items()]

    async def _find_bases(self) -> list[Finding]:
        """Find robots that have several bases."""
        settings, seen, now = self._settings, dict[Peer, float](), time.monotonic()
        names = {
            robot.namespace: (
                settings.resolve(settings.cmd_vel_topic, robot.namespace),
                settings.resolve("odom", robot.namespace),
            )
            for robot in self._robots.all()
        }
        crowded = await self._crowded(list(names.values()))
        topics = await self._topics([topic for pair in crowded for topic in pair])
        for topic in topics.values():
            for endpoint in (*topic.subscribers, *topic.publishers):
                seen[endpoint.peer] = self._since.get(endpoint.peer, now)
        self._since = seen
        settled = {peer for peer, since in seen.items() if now - since >= SETTLED}
        return [
            finding
            for robot, (velocity, odometry) in names.items()
            if velocity in topics and odometry in topics
            for finding in two_bases(robot, topics[velocity], topics[odometry], settled)
        ]

    async def _crowded(self, pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
        """Return the topics of velocity and odometry with several subscribers or publishers, which is quick to see."""
        node = self._bridge.node

        def connected(few: list[tuple[str, str]]) -> list[tuple[str, str]]:
            return [pair for pair in few if count_subscribers(node, pair[0]) > 1 or count_publishers(node, pair[1]) > 1]

        return [pair for few in _in_parts(pairs) for pair in await self._bridge.call(partial(connected, few))]

    async def _topics(self, names: list[str]) -> dict[str, Topic]:
        """Return topics by name, read a few at a time."""

        def read(few: list[str]) -> list[Topic]:
            return [read_topic(self._bridge.node, name) for name in few]

        return {topic.name: topic for few in _in_parts(names) for topic in await self._bridge.call(partial(read, few))}

    def _suspects(self, scan: Scan) -> Iterator[Suspect]:
        """Yield the topics that are not only of the types that are expected, with the robots that they belong to."""
        settings = self._settings
        names: list[str | None] = [robot.namespace for robot in self._robots.all()]
        seen: set[str] = set()  # robots may share a topic
        for robot in [*names, None]:
            for topic, expected in self._expected(robot).items():
                if topic in scan.topics and topic not in seen and set(scan.topics[topic]) - set(expected.types):
                    seen.add(topic)
                    yield robot, topic, expected
        battery = Expected((BATTERY_TYPE,), "DOCK_GATEWAY_BATTERY_TOPIC")
        for robot in self._robots.unlike(scan):
            yield robot, settings.battery_of(robot), battery

    def _expect(self, robot: str | None) -> dict[str, Expected]:
        """Return the expected types of a robot's topics, or of those of the gateway."""
        settings = self._settings
        if robot is None:
            return {settings.diagnostics_topic: Expected((DIAGNOSTICS_TYPE,), "DOCK_GATEWAY_DIAGNOSTICS_TOPIC")}
        expected = {settings.resolve(name, robot): Expected((kind,)) for name, kind in SCENE_TYPES.items()}
        for topic in settings.emergency_stop_topics:
            expected[settings.resolve(topic, robot)] = Expected(
                (STOP_TYPE,), "DOCK_GATEWAY_EMERGENCY_STOP_TOPICS", UNHEARD
            )
        return expected | {
            settings.battery_of(robot): Expected((BATTERY_TYPE,), "DOCK_GATEWAY_BATTERY_TOPIC"),
            settings.resolve(settings.stop_state_topic, robot): Expected(
                (STOP_TYPE,), "DOCK_GATEWAY_STOP_STATE_TOPIC", UNHEARD
            ),
            settings.resolve(settings.cmd_vel_topic, robot): Expected(
                VELOCITY_TYPES, "DOCK_GATEWAY_CMD_VEL_TOPIC", "A stop publishes no zero velocity there."
            ),
        }

    async def _read_topic(self, robot: str | None, name: str, types: frozenset[str]) -> tuple[Topic, frozenset[str]]:
        """Return a topic, and the nodes of gateways."""
        before = self._read.get(name)
        if before is not None and before[0] == types and time.monotonic() - before[1] < READ_AGAIN_AFTER:
            topic = before[2]
            if all(each.node is not None for each in (*topic.publishers, *topic.subscribers)):  # ROS may know it later
                return topic, before[3]
        node, stop_topic = self._bridge.node, self._settings.resolve(self._settings.stop_state_topic, robot)
        topic, gateways = await self._bridge.call(lambda: (read_topic(node, name), find_gateways(node, stop_topic)))
        self._read[name] = types, time.monotonic(), topic, gateways
        return topic, gateways


def _in_parts(items: list[T]) -> Iterator[list[T]]:
    """Yield a few items at a time."""
    for first in range(0, len(items), FEW):
        yield items[first : first + FEW]
