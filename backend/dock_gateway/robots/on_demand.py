"""Topics of robots that are subscribed to only while they are wanted, and a few seconds longer."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Protocol

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.tasks import cancel
from dock_gateway.ros.bridge import Bridge

log = logging.getLogger(__name__)

# Seconds that an unwanted port stays open, as a reloaded page soon returns; and seconds before a port that could not be
# opened is tried again.
LINGER = 3.0


class Port(Protocol):
    """A subscription to the topic of one robot, made and closed on the ROS thread."""

    def close(self) -> None:
        """End the subscription."""


class Demand(Protocol):
    """Knows whose topics are wanted, such as the fan-out, by its subscribers."""

    def watched(self, topic: str) -> set[str]:
        """Return the robots whose topic is wanted."""

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called whenever that changes."""


class OnDemand:
    """Opens and closes ports of one kind as they are wanted.

    Args:
        bridge: Runs calls on the ROS thread.
        demand: Knows which are wanted.
        topic: The kind: a name of `?include=`, or what the demand calls it.
        make: Makes the port of a robot.
        linger: See `LINGER`.
    """

    def __init__(
        self, bridge: Bridge, demand: Demand, topic: str, make: Callable[[str], Port], *, linger: float = LINGER
    ) -> None:
        self._linger = linger
        self._bridge = bridge
        self._demand = demand
        self._topic = topic
        self._make = make
        self._ports: dict[str, Port] = {}
        self._changed = asyncio.Event()
        self._task = asyncio.create_task(self._run())
        demand.on_watch(topic, self._changed.set)

    @property
    def _wanted(self) -> set[str]:
        return self._demand.watched(self._topic)

    async def _run(self) -> None:
        unwanted: dict[str, float] = {}  # since when, on the monotonic clock
        while True:
            self._changed.clear()
            await self._change(self._open, self._wanted - self._ports.keys())
            now = time.monotonic()
            unwanted = {robot: unwanted.get(robot, now) for robot in self._ports.keys() - self._wanted}
            await self._change(self._close, {robot for robot, since in unwanted.items() if now - since >= self._linger})
            settled = self._ports.keys() == self._wanted
            with suppress(TimeoutError):
                async with asyncio.timeout(None if settled else self._linger):
                    await self._changed.wait()

    async def _change(self, change: Callable[[str], Awaitable[None]], robots: set[str]) -> None:
        for robot in robots:
            try:
                await change(robot)
            except GatewayError as error:
                log.warning("cannot subscribe to %s of %s: %s", self._topic, robot, error.detail)
            except Exception:
                log.exception("while changing the subscription to %s of %s", self._topic, robot)

    async def _open(self, robot: str) -> None:
        self._ports[robot] = await self._bridge.call(lambda: self._make(robot), undo=lambda port: port.close())
        log.info("subscribed to %s of %s", self._topic, robot)

    async def _close(self, robot: str) -> None:
        self._bridge.to_ros(self._ports.pop(robot).close)
        log.info("unsubscribed from %s of %s", self._topic, robot)

    async def close(self) -> None:
        """Stop opening and closing ports."""
        await cancel(self._task)
