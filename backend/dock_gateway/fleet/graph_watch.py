"""Watches the ROS graph for what is wrong around the robots: topics of another type than expected, and the like."""

import time
from collections.abc import Iterator
from functools import lru_cache

from dock_gateway.core.dock_adapters.catalog import MAX_ROBOTS
from dock_gateway.core.graph import Topic
from dock_gateway.core.velocity_types import TYPES as VELOCITY_TYPES
from dock_gateway.fleet.findings import Expected, Finding, merge, wrong_type
from dock_gateway.robots.registry import BATTERY_TYPE, RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import STOP_TYPE, Scan, find_gateways, read_topic
from dock_gateway.ros.scene_port import SCENE_TYPES
from dock_gateway.settings import Settings

DIAGNOSTICS_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
UNHEARD = "What is said there does not stop the robot."
# Seconds after which a topic is read again although its types are the same.
READ_AGAIN_AFTER = 5.0
# The maximum number of topics that are read at one look: a node may offer thousands of a wrong type.
MAX_READ = 50

Suspect = tuple[str | None, str, Expected]


class GraphWatch:
    """Finds what is wrong on the graph.

    Args:
        settings: Names.
        bridge: Runs calls on the ROS thread.
        robots: The robots.

    Attributes:
        findings: What is wrong now.
    """

    def __init__(self, settings: Settings, bridge: Bridge, robots: RobotRegistry) -> None:
        self.findings: list[Finding] = []
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
        found = []
        suspects = [each for _, each in zip(range(MAX_READ), self._suspects(scan), strict=False)]
        self._read = {topic: self._read[topic] for _, topic, _ in suspects if topic in self._read}
        for robot, name, expected in suspects:
            topic, gateways = await self._look(robot, name, frozenset(scan.topics[name]))
            found.append(wrong_type(robot, topic, expected, gateways))
        self.findings = list(merge(filter(None, found)))

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
            yield robot, settings.resolve(settings.battery_topic, robot), battery

    def _expect(self, robot: str | None) -> dict[str, Expected]:
        """Return what is expected of a robot's topics, or of those of the gateway."""
        settings = self._settings
        if robot is None:
            return {settings.diagnostics_topic: Expected((DIAGNOSTICS_TYPE,), "DOCK_GATEWAY_DIAGNOSTICS_TOPIC")}
        expected = {settings.resolve(name, robot): Expected((kind,)) for name, kind in SCENE_TYPES.items()}
        for topic in settings.stop_topics:
            expected[settings.resolve(topic, robot)] = Expected((STOP_TYPE,), "DOCK_GATEWAY_STOP_TOPICS", UNHEARD)
        return expected | {
            settings.resolve(settings.battery_topic, robot): Expected((BATTERY_TYPE,), "DOCK_GATEWAY_BATTERY_TOPIC"),
            settings.resolve(settings.stop_topic, robot): Expected((STOP_TYPE,), "DOCK_GATEWAY_STOP_TOPIC", UNHEARD),
            settings.resolve(settings.cmd_vel_topic, robot): Expected(
                VELOCITY_TYPES, "DOCK_GATEWAY_CMD_VEL_TOPIC", "A stop publishes no zero velocity there."
            ),
        }

    async def _look(self, robot: str | None, name: str, types: frozenset[str]) -> tuple[Topic, frozenset[str]]:
        """Return a topic, and the nodes of gateways."""
        before = self._read.get(name)
        if before is not None and before[0] == types and time.monotonic() - before[1] < READ_AGAIN_AFTER:
            return before[2], before[3]
        node, stop_topic = self._bridge.node, self._settings.resolve(self._settings.stop_topic, robot)
        topic, gateways = await self._bridge.call(lambda: (read_topic(node, name), find_gateways(node, stop_topic)))
        self._read[name] = types, time.monotonic(), topic, gateways
        return topic, gateways
