"""The latest battery state, and the publisher that stands in for a robot's battery driver."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import orjson

from dock_gateway.core.battery import BatteryReading
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import robot_event, system_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Json, fragment
from dock_gateway.core.tasks import cancel
from dock_gateway.robots.plausibility import Plausibility
from dock_gateway.ros.robot_ports import BatteryPort

log = logging.getLogger(__name__)

# Minimum seconds between two events with the count of published messages.
COUNT_INTERVAL = 1.0
# Maximum seconds to wait for a message that was published to come back over ROS.
BACK_WITHIN = 0.2
NOTHING: Mapping[str, Any] = {}


@dataclass
class BatteryPublishing:
    """The state that is being published, its rate, and the number of messages published."""

    active: bool = False
    state: Any = None
    rate_hz: float | None = None
    published_count: int = 0
    started_at: datetime | None = None


class LatestBattery:
    """The latest battery state.

    Args:
        fanout: Receives battery events.
        stale_after: Age in seconds above which the state is stale.
        robot: The namespace.
        low_below: Charge (0 to 1) below which it is low; 0 means never.
        plausibility: Judges what can be believed.
    """

    def __init__(
        self,
        fanout: Fanout,
        stale_after: float,
        robot: str,
        *,
        low_below: float,
        plausibility: Plausibility | None = None,
    ) -> None:
        self._robot = robot
        self._fanout = fanout
        self._low_below = low_below
        self._stale_after = stale_after
        self._state: Json | None = None
        self._plausibility = plausibility or Plausibility()
        self._reading = BatteryReading()
        self._heard_at = 0.0
        self._received_at: datetime | None = None
        self._awaiting: set[asyncio.Queue[Json]] = set()

    async def published(self, publishing: Awaitable[Json]) -> Json:
        """Publish a message and wait until it has come back, so that it is the latest; return it as published."""
        received: asyncio.Queue[Json] = asyncio.Queue()
        self._awaiting.add(received)
        try:
            state = await publishing
            with suppress(TimeoutError):
                async with asyncio.timeout(BACK_WITHIN):
                    while await received.get() != state:
                        pass
        finally:
            self._awaiting.discard(received)
        return state

    def on_battery(self, state: Json, stamp_ns: int, infinite: Mapping[str, Any] = NOTHING) -> None:
        """Handle a message of the battery topic.

        Args:
            state: The message.
            stamp_ns: Its source timestamp.
            infinite: Its fields that are infinite, as texts: in `state` they are null.
        """
        self._state = state
        for received in self._awaiting:
            received.put_nowait(state)
        self._heard_at = time.monotonic()
        self._received_at = utc_now()
        fields = {**orjson.loads(state), **infinite}
        self._reading = self._plausibility.judge(fields, self._heard_at, self._received_at.timestamp())
        stamp = self._fanout.clock.stamp(stamp_ns)
        self._fanout.publish(robot_event("battery", self.document(), stamp, stamp_ns, robot=self._robot))

    @property
    def stale_since(self) -> datetime | None:
        """The time when the state became stale; None if it is not stale, or if there is none."""
        age, received_at = self.age, self._received_at
        if age is None or received_at is None or age <= self._stale_after:
            return None
        return received_at + timedelta(seconds=self._stale_after)

    @property
    def age(self) -> float | None:
        """Seconds since the last message; None if there was none."""
        return None if self._state is None else time.monotonic() - self._heard_at

    @property
    def reading(self) -> BatteryReading:
        """The believed values of the last message."""
        return self._reading

    def document(self) -> dict[str, Any]:
        """Return the state, its plausible values, when it came, whether it is stale and the limits, for `orjson`."""
        age, reading = self.age, self._reading
        return {
            "state": fragment(self._state),
            "percentage": reading.percentage,
            "implausible": [doubt.document() for doubt in reading.doubts],
            "received_at": self._received_at,
            "stale": age is None or age > self._stale_after,
            "stale_after_s": self._stale_after,
            "low_below": self._low_below,
        }


class BatteryPublisher:
    """Publishes battery states, once or at a rate, as `ros2 topic pub` does."""

    def __init__(self, port: BatteryPort, battery: LatestBattery, fanout: Fanout, robot: str) -> None:
        self._robot = robot
        self._battery = battery
        self._port = port
        self._fanout = fanout
        self._publisher = BatteryPublishing()
        self._task: asyncio.Task[None] | None = None
        self._changing = asyncio.Lock()
        self._published_at = 0.0

    @property
    def active(self) -> bool:
        """Whether a state is being published at a rate."""
        return self._publisher.active

    def document(self) -> dict[str, Any]:
        """Return the publisher's state, ready for `orjson`."""
        return dict(vars(self._publisher))

    async def publish(self, value: object, path: str = "") -> Json:
        """Publish one partial BatteryState; return the message as sent. `path` is the field's path, for errors.

        Raises:
            InvalidField: It is not a BatteryState.
        """
        message = self._port.codec.parse(value, path)
        return await self._battery.published(self._port.publish(message, stamp=_unstamped(message)))

    async def start(self, value: object, rate_hz: float) -> None:
        """Publish a partial BatteryState `rate_hz` times a second, replacing the state published before.

        Raises:
            InvalidField: It is not a BatteryState.
        """
        message = self._port.codec.parse(value, "state")
        async with self._changing:
            await self._cancel()
            stamp = _unstamped(message)
            state = fragment(await self._port.publish(message, stamp=stamp))
            self._publisher = BatteryPublishing(True, state, rate_hz, 1, utc_now())
            self._task = asyncio.create_task(self._run(message, 1 / rate_hz, stamp=stamp))
            self._publish_count()

    async def stop(self) -> None:
        """Stop publishing."""
        async with self._changing:
            was_active = self._publisher.active
            await self._cancel()
            if was_active:
                self._publish_count()

    async def _cancel(self) -> None:
        task, self._task = self._task, None
        self._publisher = BatteryPublishing()
        if task is not None:
            await cancel(task)

    async def _run(self, message: Any, period: float, *, stamp: bool) -> None:
        due = time.monotonic() + period
        while True:
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            due = max(due + period, time.monotonic())  # missed messages are not made up for
            try:
                await self._port.publish(message, stamp=stamp)
            except GatewayError as error:
                log.warning("the battery state could not be published: %s", error.detail)
                continue
            self._publisher.published_count += 1
            if time.monotonic() - self._published_at >= COUNT_INTERVAL:
                self._publish_count()

    def _publish_count(self) -> None:
        self._published_at = time.monotonic()
        self._fanout.publish(system_event("battery_publisher", self.document(), utc_now(), robot=self._robot))


def _unstamped(message: Any) -> bool:
    return bool(message.header.stamp.sec == 0 and message.header.stamp.nanosec == 0)
