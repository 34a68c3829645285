"""Is the battery charging: by its status, by its current, or by where the robot stands."""

from docking.core.battery import BatteryReading, describe_status
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.parameters import ChargingSettings, ChargingSource

MOVING, TURNING = 0.06, 0.1
"""In m/s and rad/s: faster than robots drive onto the last centimetres, with the contacts at the charger's."""


def tells_charging(battery: BatteryReading, settings: ChargingSettings, velocity: Velocity = STANDSTILL) -> bool:
    """Whether a battery message tells that the battery charges; never where the pose is to tell it.

    Args:
        battery: The message.
        settings: What tells that the battery charges.
        velocity: Of the robot. Who moves is on no charger: a current is then that of the motors, its sign set wrong.
    """
    if settings.charging_source is ChargingSource.STATUS:
        return battery.connected
    if settings.charging_source is ChargingSource.CURRENT:
        moves = abs(velocity.linear_x) > MOVING or abs(velocity.angular_z) > TURNING
        return not moves and current_in(battery, settings) > settings.charging_threshold  # NaN is above nothing
    return False


def stands_docked(robot: Pose | None, docked: Pose | None, settings: ChargingSettings, threshold: float) -> bool:
    """Whether the robot charges by where it stands; only where the pose is to tell it.

    Args:
        robot: base_link in odom; None if unknown.
        docked: The same when docked.
        settings: What tells that the battery charges.
        threshold: The most that both may differ by, in m.
    """
    if settings.charging_source is not ChargingSource.POSE or robot is None or docked is None:
        return False
    return robot.distance_to(docked) <= threshold


def current_in(battery: BatteryReading, settings: ChargingSettings) -> float:
    """The current into the battery, in A; NaN if it is not measured or cannot be right."""
    current = battery.believed_current
    return -current if settings.charging_current_negative else current


def describe_charging(battery: BatteryReading, settings: ChargingSettings) -> str:
    """What a battery message tells of charging, as half a sentence."""
    if settings.charging_source is ChargingSource.CURRENT:
        return f"its current is {battery.current:g} A"
    return f"its battery is {describe_status(battery.status)}"
