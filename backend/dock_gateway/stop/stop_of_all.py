"""A stop of all robots where several gateways have a share each: every gateway hears it, and stops its own robots."""

from functools import partial

from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.core.tasks import Tasks
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.latch_port import LatchPort
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper


class StopOfAll:
    """Joins `stop_latched` without a namespace, whose stop holds for every robot.

    A release there is that of each gateway's own robots: those of the others stay stopped until they are released at
    their gateway.

    Args:
        settings: Names.
        robots: The robots of this gateway's share.
        interlock: The latched stops.
        stopper: Stops the robots.
    """

    def __init__(self, settings: Settings, robots: RobotRegistry, interlock: Interlock, stopper: Stopper) -> None:
        self._settings = settings
        self._robots = robots
        self._interlock = interlock
        self._stopper = stopper
        self._port: LatchPort | None = None
        self._tasks = Tasks("stopping the robots of a share")

    async def open(self) -> None:
        """Join the topic, unless it is that of a robot of the share, or there are no shares.

        Raises:
            Unavailable: The ROS thread is down.
        """
        if not self._settings.serve_robots:
            return
        self._interlock.on_heard.append(self._heard)
        if ALL_ROBOTS in self._robots:
            return
        resolve = partial(self._settings.resolve, namespace=ALL_ROBOTS)

        def hear_latch(latched: bool, received: float) -> None:
            self._interlock.heard(ALL_ROBOTS, latched=latched, received=received)

        def make() -> LatchPort:
            return LatchPort(
                self._robots.topics,
                resolve(self._settings.stop_state_topic),
                map(resolve, self._settings.emergency_stop_topics),
                on_latch=hear_latch,
                on_hold=lambda by: self._interlock.held_by_another(ALL_ROBOTS, by),
            )

        bridge = self._robots.topics.bridge
        self._port = await bridge.call(make, undo=LatchPort.close)
        self._interlock.join(ALL_ROBOTS, self._port, robot=False)

    def _heard(self, namespace: str) -> None:
        """Stop the robots as if that had been requested here: with zero velocity, their goals canceled, latched."""
        if namespace == ALL_ROBOTS and (robots := self._robots.namespaces()):
            self._tasks.spawn(self._stopper.stop(*robots))

    async def close(self) -> None:
        """Stop no more."""
        await self._tasks.close()
