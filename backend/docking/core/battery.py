"""The battery as the nodes of this process share it: its latest message and when that came."""

import enum
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace


class PowerSupplyStatus(enum.IntEnum):
    """`power_supply_status` of sensor_msgs/BatteryState."""

    UNKNOWN = 0
    CHARGING = 1
    DISCHARGING = 2
    NOT_CHARGING = 3
    FULL = 4


BATTERY_TYPE = "sensor_msgs/msg/BatteryState"
STATUSES = frozenset(PowerSupplyStatus)
MAX_NAMED = 5
"""Of the topics that are named."""
CONNECTED = frozenset({PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL})
"""The states of a battery that is connected to its charger; every other number, known or not, is none."""


FULL = 0.95
"""State of charge above which many chargers wait until it is below again."""
MAX_CURRENT = 1000.0
"""In A; the battery of a robot has no more."""


def describe_absence(topic: str, types: Iterable[str], others: Iterable[str]) -> str:
    """Describe the graph where there are no battery messages, as the end of a sentence.

    Args:
        topic: Where they are expected.
        types: The types that are published there.
        others: Other topics with battery messages.
    """
    wrong, found = sorted(set(types) - {BATTERY_TYPE}), sorted(others)
    where = f"{topic} is {' and '.join(wrong)}, not {BATTERY_TYPE}" if wrong else f"nothing comes on {topic}"
    if not found:
        return where
    more = f" and {len(found) - MAX_NAMED} more" if len(found) > MAX_NAMED else ""
    return f"{where}, but batteries are on {', '.join(found[:MAX_NAMED])}{more}: remap battery_status to the robot's"


def describe_status(status: int) -> str:
    """A status as a person reads it: its number, and its name where it has one."""
    try:
        return f"{status} ({PowerSupplyStatus(status).name})"
    except ValueError:
        return f"{status} (no known status)"


@dataclass(frozen=True)
class BatteryReading:
    """One battery message.

    Attributes:
        status: `power_supply_status` as it came, which need not be a known one.
        received_at: When it reached this process, in seconds of the monotonic clock.
        message: The sensor_msgs/BatteryState itself, which nothing here looks into.
        percentage: State of charge, from 0 to 1; NaN if it is not measured.
        current: In A; drivers differ in which direction is positive. NaN where it is not measured.
        full_at: When the battery was full the last time, by the same clock as `received_at`; -inf if it was not.
    """

    status: int
    received_at: float
    message: object = None
    percentage: float = math.nan
    current: float = math.nan
    full_at: float = field(default=-math.inf, compare=False)

    @property
    def filled(self) -> bool:
        """Whether it is full, or so full that chargers wait; not whether it is at one."""
        return self.status == PowerSupplyStatus.FULL or FULL <= self.percentage <= 1.0

    @property
    def connected(self) -> bool:
        """Whether the charger is connected: charging, or full."""
        return self.status in CONNECTED

    @property
    def fault(self) -> str | None:
        """The publisher's faults that docking can tolerate, as a text that follows the topic's name."""
        faults = []
        if not (math.isnan(self.percentage) or 0.0 <= self.percentage <= 1.0):
            faults.append(f"has a percentage of {self.percentage:g}, but it must be from 0 to 1")
        if abs(self.current) > MAX_CURRENT:
            faults.append(f"has a current of {self.current:g} A, but one above {MAX_CURRENT:g} A is not believed")
        if self.status not in STATUSES:
            faults.append(f"has the power_supply_status {describe_status(self.status)}")
        return ", and ".join(faults) or None

    @property
    def believed_current(self) -> float:
        """The current in A; NaN if it is not measured or cannot be right, as in mA."""
        return math.nan if abs(self.current) > MAX_CURRENT else self.current

    def age(self, now: float) -> float:
        """Seconds since it was received; negative if it is ahead of the clock."""
        return now - self.received_at


class Battery:
    """The latest reading, written by the battery subscriber and read by the action server.

    Attributes:
        latest: None until the first message has come.
        on_connected: Called at once with each reading of a connected charger.
    """

    def __init__(self) -> None:
        self.latest: BatteryReading | None = None
        self.on_connected: Callable[[], None] | None = None
        self._full_at = -math.inf

    def update(self, reading: BatteryReading) -> None:
        """Update with a newer reading."""
        if reading.filled:
            self._full_at = reading.received_at
        self.latest = replace(reading, full_at=self._full_at)
        if reading.connected and self.on_connected is not None:
            self.on_connected()
