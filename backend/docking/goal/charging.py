"""Is the battery charging: by its status, by its current, or by where the robot stands; and how often it broke off."""

import math

from docking.core.battery import FULL, BatteryReading, PowerSupplyStatus, describe_status
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.parameters import ChargingSettings, ChargingSource

MOVING, TURNING = 0.06, 0.1
"""In m/s and rad/s: faster than robots drive onto the last centimetres, with the contacts at the charger's."""
FLICKERS = 3
"""Number of interruptions from which a charge counts as flickering."""
MESSAGES, RARE_MESSAGES = 3, 5
"""How many messages in a row must say that the battery charges; the second where fewer than two come in a second.

Twice as many after one that said otherwise: rare messages see little of a charge that flickers.
"""
OFTEN = 0.5
"""Mean seconds between messages that are not rare."""
ROUNDING = 1e-9


def tells_charging(battery: BatteryReading, settings: ChargingSettings, velocity: Velocity = STANDSTILL) -> bool:
    """Whether a battery message tells that the battery charges; never where the pose is to tell it.

    Args:
        battery: The message.
        settings: How charging is detected.
        velocity: Of the robot. Who moves is on no charger: a current is then that of the motors, its sign set wrong.
    """
    if settings.charging_source is ChargingSource.STATUS:
        return battery.connected
    if settings.charging_source is ChargingSource.CURRENT:
        current = current_in(battery, settings)
        return not moves(velocity) and current > settings.charging_threshold  # NaN is above nothing
    return False


def moves(velocity: Velocity) -> bool:
    """Whether a robot is faster than on a charger's contacts."""
    return abs(velocity.linear_x) > MOVING or abs(velocity.angular_z) > TURNING


def stands_docked(robot: Pose | None, docked: Pose | None, settings: ChargingSettings, threshold: float) -> bool:
    """Whether the robot charges, or is docked, by where it stands; only where the pose is to tell it.

    Args:
        robot: base_link in odom; None if unknown.
        docked: The same when docked.
        settings: How charging is detected.
        threshold: The most that both may differ by, in m.
    """
    if not settings.by_pose or robot is None or docked is None:
        return False
    return robot.distance_to(docked) <= threshold


def current_in(battery: BatteryReading, settings: ChargingSettings) -> float:
    """The current into the battery, in A; NaN if it is not measured or cannot be right."""
    current = battery.believed_current
    return -current if settings.charging_current_negative else current


def describe_charging(battery: BatteryReading | None, settings: ChargingSettings) -> str:
    """Describe the charging state in a battery message, as the end of a sentence."""
    if battery is None or not settings.charges:
        return "its dock does not charge"
    if settings.charging_source is ChargingSource.CURRENT:
        return f"its current is {battery.current:g} A"
    return f"its battery is {describe_status(battery.status)}"


def is_full(battery: BatteryReading) -> bool:
    """Whether a full battery is connected to a charger that does not charge it now."""
    at_charger = battery.status in {PowerSupplyStatus.NOT_CHARGING, PowerSupplyStatus.FULL}
    return at_charger and FULL <= battery.percentage <= 1.0


class ChargeRecord:
    """Keeps count of the charges of one goal.

    What counts is what the battery has said, not the time since: a driver may say it ten times a second, or every 5 s.

    Attributes:
        breaks: Number of charges that broke off.
    """

    def __init__(self, stable_for: float) -> None:
        """Start without a charge.

        Args:
            stable_for: How long a charge must last, in s; where it is 0, one message is enough.
        """
        self.breaks = 0
        self._count = 0
        self._stable_for = stable_for
        self._first_at = self._broke_at = math.nan
        self._began_at: float | None = None
        self._heard_at = math.nan
        self._longest = 0.0
        self._current = math.nan
        self._highest = math.nan
        self._status = 0

    @property
    def flickers(self) -> bool:
        """Whether the charge comes and goes."""
        return self.breaks >= FLICKERS

    @property
    def charges(self) -> bool:
        """Whether the last message said so."""
        return self._began_at is not None

    @property
    def is_stable(self) -> bool:
        """Whether enough messages have said so, for long enough, and none said otherwise."""
        if self._began_at is None or self._stable_for == 0.0:
            return self.charges
        lasted = self._heard_at - self._began_at + ROUNDING
        often = lasted <= OFTEN * (self._count - 1) + 2.0 * ROUNDING
        least = (MESSAGES if often else RARE_MESSAGES) * (2 if self.breaks else 1)
        return self._count >= least and lasted >= self._stable_for

    def longest(self, silence: float) -> float:
        """The longest that a charge may last, in s, before it is stable or breaks off, but for silences.

        Args:
            silence: The longest time between two messages that is none.
        """
        return self._stable_for + 2 * RARE_MESSAGES * silence if self._stable_for else 0.0

    def hear(self, at: float, reading: BatteryReading | None, *, charges: bool) -> None:
        """Take notice of a battery message, or of the pose: to be called once for each.

        Args:
            at: When it came.
            reading: The battery message; None where the pose tells it.
            charges: Whether it charges by that.
        """
        self._heard_at = at
        if reading is not None:
            self._status, self._current = reading.status, reading.current
        if charges:
            self._count += 1
            if self._began_at is None:
                self._began_at = at
                self._first_at = self._first_at if self.breaks else at
            self._highest = max(
                self._current, self._highest, key=lambda current: (not math.isnan(current), abs(current))
            )
        elif self._began_at is not None:
            self.breaks += 1
            self._broke_at, self._longest = at, max(self._longest, at - self._began_at)
            self._began_at, self._count = None, 0

    def describe(self) -> str:
        """Describe the interrupted charges, as the end of a sentence; empty without any."""
        if not self.breaks:
            return ""
        if self.breaks == 1:
            what = "broke off once"
        else:
            what = f"flickered: it broke off {self.breaks} times within {self._broke_at - self._first_at:.1f} s"
        now = "" if math.isnan(self._current) else f", the current {self._current:.3g} A"
        then = "" if math.isnan(self._highest) else f", and up to {self._highest:.3g} A while it charged"
        return (
            f"the charge {what}, after {self._longest:.1f} s at most (charge_stable_for is {self._stable_for:g} s); the"
            f" status is now {describe_status(self._status)}{now}{then}. Are the contacts clean?"
        )
