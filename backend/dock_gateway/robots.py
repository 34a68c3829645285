"""A robot is a namespace: its battery topic, its velocity topic, its actions."""

import logging
from dataclasses import dataclass

from dock_gateway.battery import Battery, BatteryPublisher
from dock_gateway.errors import FieldError, InvalidField, NotFound
from dock_gateway.events import message_event
from dock_gateway.goals import Json
from dock_gateway.hub import Hub
from dock_gateway.interlock import Interlock
from dock_gateway.namespaces import is_under
from dock_gateway.outcomes import Outcomes
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan
from dock_gateway.ros.topics import BatteryPort, LatchPort, VelocityPort
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Robot:
    """What belongs to one namespace."""

    namespace: str
    battery: Battery
    publisher: BatteryPublisher
    velocity: VelocityPort


class RobotRegistry:
    """The robots on the graph: the configured one always, others as their battery topic or docking action appears."""

    def __init__(self, settings: Settings, bridge: Bridge, hub: Hub, interlock: Interlock, outcomes: Outcomes) -> None:
        self._settings = settings
        self._bridge = bridge
        self._hub = hub
        self._interlock = interlock
        self._outcomes = outcomes
        self._robots: dict[str, Robot] = {}
        self.default_namespace = normalize_namespace(settings.namespace)

    async def open(self, namespace: str) -> Robot:
        """Join the topics of a robot."""
        settings, hub = self._settings, self._hub
        battery = Battery(hub, settings.battery_stale_after, namespace)

        def hear_velocity(message: Json, stamp_ns: int) -> None:
            hub.publish(message_event("cmd_vel", message, stamp_ns, robot=namespace))

        def hear_latch(latched: bool) -> None:
            self._interlock.heard(namespace, latched=latched)

        def make() -> tuple[BatteryPort, VelocityPort, LatchPort]:
            battery_topic = settings.resolve(settings.battery_topic, namespace)
            velocity_topic = settings.resolve(settings.cmd_vel_topic, namespace)
            return (
                BatteryPort(self._bridge, battery_topic, battery.on_battery),
                VelocityPort(self._bridge, velocity_topic, hear_velocity),
                LatchPort(self._bridge, settings.resolve(settings.stop_topic, namespace), hear_latch),
            )

        battery_port, velocity, latch = await self._bridge.call(make)
        robot = Robot(namespace, battery, BatteryPublisher(battery_port, hub, namespace), velocity)
        self._robots[namespace] = robot
        self._interlock.join(namespace, latch)
        self._outcomes.watch(*settings.docking_actions(namespace))
        log.info("robot %s", namespace)
        return robot

    async def update(self, scan: Scan) -> None:
        """Take up robots that have appeared. None is forgotten: a battery that falls silent is news, not the end."""
        settings = self._settings
        suffixes = tuple(f"/{name}" for name in (settings.dock_action, settings.undock_action, settings.battery_topic))
        for name in (*scan.actions, *scan.topics):
            for suffix in suffixes:
                if name.endswith(suffix) and (namespace := name.removesuffix(suffix) or "/") not in self._robots:
                    await self.open(namespace)

    def all(self) -> list[Robot]:
        """The robots, by namespace."""
        return sorted(self._robots.values(), key=lambda robot: robot.namespace)

    def under(self, namespace: str) -> list[Robot]:
        """The robot of a namespace and those below it."""
        return [robot for robot in self.all() if is_under(robot.namespace, namespace)]

    def owner(self, name: str) -> Robot | None:
        """The robot that an action belongs to: the one with the longest namespace that it is in."""
        while name:
            name = name.rpartition("/")[0]
            if robot := self._robots.get(name or "/"):
                return robot
        return None

    def get(self, namespace: str | None = None) -> Robot:
        """The robot of a namespace, the configured one where none is named.

        Raises:
            NotFound: `robot_not_found`.
        """
        name = self.default_namespace if namespace is None else read_namespace(namespace)
        robot = self._robots.get(name)
        if robot is None:
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return robot

    async def close(self) -> None:
        """Publish no more."""
        for robot in self.all():
            await robot.publisher.stop()


def normalize_namespace(namespace: str) -> str:
    """`robot1`, `/robot1` and `/robot1/` are `/robot1`; nothing is `/`."""
    return f"/{namespace.strip('/')}"


def read_namespace(namespace: str) -> str:
    """A namespace that a client named.

    Raises:
        InvalidField: It is not one.
    """
    parts = namespace.strip("/").split("/") if namespace.strip("/") else []
    if not namespace.startswith("/") or not all(part.isidentifier() and part.isascii() for part in parts):
        raise InvalidField([FieldError("query.robot", "a ROS namespace such as /robot1", f"got {namespace[:60]!r}")])
    return normalize_namespace(namespace)
