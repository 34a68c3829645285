"""The robots. A robot is a namespace with a battery topic, a velocity topic and actions."""

import logging
from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Literal

from dock_gateway.core.discovery import Discovery
from dock_gateway.core.dock_adapters.catalog import ADAPTERS, DockingCatalog
from dock_gateway.core.errors import NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import is_hidden, is_under, prefix_of
from dock_gateway.core.listeners import Hooks, Listeners
from dock_gateway.core.namespace import ALL_ROBOTS, normalize_namespace, read_namespace
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.battery import BatteryPublisher, LatestBattery
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.plausibility import Plausibility
from dock_gateway.robots.wheels import Wheels
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Presence, Scan, find_presence
from dock_gateway.ros.latch_port import LatchPort
from dock_gateway.ros.robot_ports import BatteryPort
from dock_gateway.ros.typed_topics import TypedTopics
from dock_gateway.ros.velocity import VelocityPort, VelocityTopics
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)


BATTERY_TYPE = "sensor_msgs/msg/BatteryState"

# What makes a robot of a namespace: a docking action server, a battery that is published, a base that listens.
RobotPart = Literal["server", "battery", "base"]

Ports = tuple[BatteryPort, VelocityPort, LatchPort]


@dataclass(frozen=True)
class Robot:
    """One robot. `ports` are all of its topics that the gateway uses; the stop's is the last."""

    namespace: str
    battery: LatestBattery
    publisher: BatteryPublisher
    wheels: Wheels
    ports: Ports


class RobotRegistry:
    """The robots: the configured one always, others once a battery or a docking action of theirs appears.

    Of a gateway with a share, only those of its share. It may have no configured one.

    Attributes:
        velocities: Their velocity topics.
        topics: Their other topics.
    """

    own_robot = True

    def __init__(
        self,
        settings: Settings,
        bridge: Bridge,
        fanout: Fanout,
        interlock: Interlock,
        last_goals: LastGoals,
        *,
        share: Share = EVERYTHING,
    ) -> None:
        self._settings = settings
        self._share = share
        self._bridge = bridge
        self._fanout = fanout
        self._interlock = interlock
        self._last_goals = last_goals
        self._catalog = DockingCatalog(settings)
        self._robots: dict[str, Robot] = {}
        self._forgotten: set[str] = set()
        self._battery_topics: list[str] = []  # all on the graph
        self.velocities = VelocityTopics(bridge)
        self.topics = TypedTopics(bridge)
        self._discovery = Discovery("robot", settings.max_robots, "max_robots")
        self.default_namespace = normalize_namespace(settings.namespace)
        self.on_scan = Listeners[[Scan]]("the ROS graph was scanned")
        self.before_removal = Hooks[Callable[[str], Awaitable[None]]]()  # called with the robot
        self.at_work = Hooks[Callable[[str], bool]]()  # whether a robot has work that lasts longer than a goal
        # Asks whoever has a robot at work to let it charge, below this charge (0 to 1).
        self.on_low_battery = Listeners[[str, float]]("a robot at work has to charge")

    async def scanned(self, found: Scan) -> None:
        """Pass on a scan of the ROS graph."""
        self.on_scan(found)

    def is_at_work(self, namespace: str) -> bool:
        """Return whether a robot has work of which a goal is only a part: nothing else is to move it meanwhile."""
        return any(has_work(namespace) for has_work in self.at_work)

    async def leave(self, namespace: str) -> None:
        """Let all leave the topics of a robot that is about to be removed.

        Afterwards this gateway is not known as a node there, and its subscriptions would count as the robot's.
        """
        for leave in self.before_removal:
            try:
                await leave(namespace)
            except Exception:
                log.exception("while leaving the topics of %s", namespace)

    async def open(self, namespace: str) -> Robot:
        """Join the topics of a robot."""
        settings, fanout = self._settings, self._fanout
        battery = LatestBattery(
            fanout,
            settings.battery_stale_after,
            namespace,
            low_below=settings.low_battery,
            plausibility=Plausibility(
                counts_to_100=settings.counts_to_100(namespace),
                charges_negative=settings.charges_negative(namespace),
            ),
        )

        def hear_latch(latched: bool, received: float) -> None:
            self._interlock.heard(namespace, latched=latched, received=received)

        def hear_hold(by: str | None) -> None:
            self._interlock.held_by_another(namespace, by)

        def make() -> Ports:
            battery_topic = settings.battery_of(namespace)
            velocity_topic = settings.resolve(settings.cmd_vel_topic, namespace)
            stop_topic = settings.resolve(settings.stop_state_topic, namespace)
            with ExitStack() as undo:
                battery_port = BatteryPort(self.topics, battery_topic, battery.on_battery, stop_topic)
                undo.callback(battery_port.close)
                velocity_port = VelocityPort(self.velocities, velocity_topic, stop_topic)
                undo.callback(velocity_port.close)
                others = [settings.resolve(name, namespace) for name in settings.emergency_stop_topics]
                latch_port = LatchPort(self.topics, stop_topic, others, on_latch=hear_latch, on_hold=hear_hold)
                ports = battery_port, velocity_port, latch_port
                undo.pop_all()
            return ports

        ports = await self._bridge.call(make, undo=_leave)
        battery_port, velocity, latch = ports
        robot = Robot(
            namespace, battery, BatteryPublisher(battery_port, battery, fanout, namespace), Wheels(velocity), ports
        )
        self._robots[namespace] = robot
        self._forgotten.discard(namespace)
        self._interlock.join(namespace, latch)
        self._last_goals.watch(*(self._catalog.names(verb, namespace)[0] for verb in ADAPTERS))
        log.info("robot %s", namespace)
        return robot

    async def update(self, scan: Scan) -> bool:
        """Add robots that appeared or are back; return whether some are still to be added.

        A topic used only by another gateway does not bring back a removed robot.

        Raises:
            Unavailable: The ROS thread is down.
        """
        self._battery_topics = sorted(name for name, types in scan.topics.items() if BATTERY_TYPE in types)
        found = [self._catalog.robot_of(name, types) for name, types in scan.actions.items()]
        found += [namespace for namespace, types in self._batteries(scan) if BATTERY_TYPE in types]
        new = [each for each in dict.fromkeys(found) if each and each not in self._robots]
        new = list(filter(self._share.covers_robot, new))

        async def take_up(namespace: str) -> None:
            if namespace not in self._forgotten or await self.is_there(namespace, scan):
                await self.open(namespace)

        self._discovery.keep(new)
        return await self._discovery.take_up(new, self._robots, take_up)

    async def other_batteries(self, robot: Robot) -> list[str]:
        """Return the topics that batteries are published on, if that of a robot has sent nothing.

        Raises:
            Unavailable: The ROS thread is down.
        """
        if robot.battery.age is not None:
            return []
        # We may publish on those of robots ourselves.
        silent = {
            self._settings.battery_of(each.namespace) for each in self._robots.values() if each.battery.age is None
        }
        topics = [topic for topic in self._battery_topics if topic not in silent and not is_hidden(topic)]
        node = self._bridge.node
        return await self._bridge.call(lambda: [topic for topic in topics if node.count_publishers(topic)])

    def _batteries(self, scan: Scan) -> Iterator[tuple[str, list[str]]]:
        """Yield the namespaces with a topic that has the name of a battery's, and its types."""
        suffix = f"/{self._settings.battery_topic}"
        own = {topic: robot for robot, topic in self._settings.own_batteries.items()}
        for name, types in scan.topics.items():
            if name in own:
                yield own[name], types
            elif name.endswith(suffix) and self._catalog.may_be_robot(namespace := name.removesuffix(suffix) or "/"):
                yield namespace, types

    def unlike(self, scan: Scan) -> list[str]:
        """Return the namespaces that make no robot, as their battery topic is of another type."""
        return [
            namespace
            for namespace, types in self._batteries(scan)
            if types
            and BATTERY_TYPE not in types
            and namespace not in self._robots
            and self._share.covers_robot(namespace)
        ]

    async def parts(self, namespace: str, scan: Scan) -> frozenset[RobotPart]:
        """Return what a robot has on the graph that makes it one; nodes in its namespace alone do not.

        Raises:
            Unavailable: The ROS thread is down.
        """
        presence = await self._presence(namespace, [self._settings.battery_of(namespace)])
        prefix, place, robot_of = prefix_of(namespace), self._catalog.place_of, self._catalog.robot_of
        inside = (item for item in scan.actions.items() if place(item[0]).startswith(prefix))
        server = any(robot_of(name, types) == namespace for name, types in inside)
        parts: dict[RobotPart, bool] = {"server": server, "battery": presence.publishes, "base": presence.base}
        return frozenset(part for part, present in parts.items() if present)

    async def is_there(self, namespace: str, scan: Scan) -> bool:
        """Return whether anything but gateways is in a namespace, not counting the namespaces of robots below.

        Of the root, whose names are those of nodes and topics of all robots, only the `parts` count.

        Raises:
            Unavailable: The ROS thread is down.
        """
        if namespace == "/":
            return bool(await self.parts(namespace, scan))
        prefix = prefix_of(namespace)

        def belongs(name: str) -> bool:
            if not name.startswith(prefix):  # most do not, and there are thousands
                return False
            owner = self.owner(name)
            return owner is None or is_under(namespace, owner.namespace)

        if any(belongs(name) for name in scan.actions):
            return True
        presence = await self._presence(namespace, [name for name in scan.topics if belongs(name)])
        return presence.publishes or presence.base or any(belongs(name) for name in presence.nodes)

    async def _presence(self, namespace: str, topics: list[str]) -> Presence:
        settings = self._settings
        return await self._bridge.call(
            lambda: find_presence(
                self._bridge.node,
                topics,
                stop_topic=settings.resolve(settings.stop_state_topic, namespace),
                velocity_topic=settings.resolve(settings.cmd_vel_topic, namespace),
            )
        )

    def forget(self, namespace: str) -> None:
        """Leave the topics of a robot that is gone. If it appears again, its past is restored."""
        robot = self._robots.pop(namespace)
        robot.wheels.leave()
        self._forgotten.add(namespace)
        self._interlock.leave(namespace)
        self._bridge.to_ros(lambda: _leave(robot.ports))

    def __contains__(self, namespace: str) -> bool:
        return namespace in self._robots

    def namespaces(self) -> list[str]:
        """Return the namespaces of all robots."""
        return [robot.namespace for robot in self.all()]

    def all(self) -> list[Robot]:
        """Return the robots, sorted by namespace."""
        return sorted(self._robots.values(), key=lambda robot: robot.namespace)

    def under(self, namespace: str) -> list[Robot]:
        """Return the robot of a namespace and those below it."""
        return [robot for robot in self.all() if is_under(robot.namespace, namespace)]

    def owner(self, name: str) -> Robot | None:
        """Return the robot that an action belongs to: the one with the longest namespace containing it."""
        name = self._catalog.place_of(name)
        while name:
            name = name.rpartition("/")[0]
            if robot := self._robots.get(name or "/"):
                return robot
        return None

    def get(self, namespace: str | None = None) -> Robot:
        """Return the robot of a namespace; default: the configured one.

        Raises:
            NotFound: `robot_not_found`.
            ServedElsewhere: It is not one of this gateway's.
        """
        name = self.default_namespace if namespace is None else read_namespace(namespace)
        robot = self._robots.get(name)
        if robot is None:
            self._share.require_robot(name)
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return robot

    def find(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot, as `get`.

        If none is named and none is configured, it is the first of the share; `/` if there is none.
        """
        if namespace is None and self.default_namespace not in self:
            return min(self._robots, default="/")
        return self.get(namespace).namespace

    def place(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot, or `/`, which is all robots that the gateway serves; default: all.

        Raises:
            NotFound, ServedElsewhere: As `get`.
        """
        name = ALL_ROBOTS if namespace is None else read_namespace(namespace)
        return name if name == ALL_ROBOTS else self.get(name).namespace

    async def close(self) -> None:
        """Stop publishing battery states."""
        for robot in self.all():
            await robot.publisher.stop()


def _leave(ports: Ports) -> None:
    for port in ports:
        port.close()
