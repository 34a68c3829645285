"""The simulator's messages. Those that are sent often are reused."""

from array import array
from collections.abc import Mapping

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import BatteryState, JointState, LaserScan, Range

from docking.core.geometry import Pose, quaternion_of
from docking.core.observation import Velocity
from docking.goal.report import Level
from docking.ros.diagnostics import status_message
from docking.simulation.battery import BatteryMeasurement
from docking.simulation.infrared import InfraredSettings
from docking.simulation.laser import ANGLE_MIN, Distances, LaserSettings
from docking.simulation.occupancy import CELL, Occupancy

MAP = "map"
WORLD = "world"
ODOM = "odom"
BASE = "base_link"
LASER = "laser"


class OdometryMessage:
    """A nav_msgs/Odometry."""

    def __init__(self, frame: str, child: str = BASE) -> None:
        """Make the message.

        Args:
            frame: The frame of its poses.
            child: The frame of its velocities.
        """
        self._message = Odometry(child_frame_id=child)
        self._message.header.frame_id = frame

    def fill(self, pose: Pose, velocity: Velocity, stamp: Time) -> Odometry:
        """The message, until it is filled again."""
        message = self._message
        message.header.stamp = stamp
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        position.x, position.y = pose.x, pose.y
        turn.z, turn.w = quaternion_of(pose.theta)[2:]
        message.twist.twist.linear.x = velocity.linear_x
        message.twist.twist.linear.y = velocity.linear_y
        message.twist.twist.angular.z = velocity.angular_z
        return message


def joint_message(wheels: Mapping[str, tuple[float, float]], stamp: Time) -> JointState:
    """A sensor_msgs/JointState of the wheels: velocities in rad/s and efforts in N·m, by name."""
    velocities, efforts = zip(*wheels.values(), strict=True)
    message = JointState(name=list(wheels), velocity=velocities, effort=efforts)
    message.header.stamp = stamp
    return message


class RangeMessage:
    """A sensor_msgs/Range of an infrared receiver."""

    def __init__(self, receiver: str, settings: InfraredSettings) -> None:
        """Make the message.

        Args:
            receiver: `left`, `center` or `right`.
            settings: Of the receivers.
        """
        self._message = Range(
            radiation_type=Range.INFRARED,
            field_of_view=settings.field_of_view,
            min_range=settings.minimum,
            max_range=settings.range,
            variance=settings.noise**2,
        )
        self._message.header.frame_id = f"infrared_{receiver}"

    def fill(self, distance: float, stamp: Time) -> Range:
        """The message, until it is filled again; infinite is nothing seen (REP-117)."""
        self._message.header.stamp = stamp
        self._message.range = distance
        return self._message


class ScanMessage:
    """The sensor_msgs/LaserScan of the laser scanner."""

    def __init__(self, settings: LaserSettings) -> None:
        """Make the message.

        Args:
            settings: Of the scanner.
        """
        self._message = LaserScan(
            angle_min=ANGLE_MIN,
            angle_max=ANGLE_MIN + (settings.rays - 1) * settings.angle_increment,
            angle_increment=settings.angle_increment,
            scan_time=1.0 / settings.rate,
            range_min=settings.minimum,
            range_max=settings.range,
        )
        self._message.header.frame_id = LASER

    def fill(self, distances: Distances, stamp: Time) -> LaserScan:
        """The message, until it is filled again; infinite is nothing seen (REP-117)."""
        self._message.header.stamp = stamp
        self._message.ranges = distances.tolist()
        return self._message


class BatteryMessage:
    """The sensor_msgs/BatteryState of the simulated battery."""

    def __init__(self) -> None:
        self._message = BatteryState(
            power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_GOOD,
            power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_NIMH,
            present=True,
            location="dock_simulator",
        )
        self._message.header.frame_id = BASE

    def fill(self, measured: BatteryMeasurement, stamp: Time) -> BatteryState:
        """The message, until it is filled again."""
        message = self._message
        message.header.stamp = stamp
        message.voltage = measured.voltage
        message.temperature = measured.temperature
        message.current = measured.current
        message.charge = measured.charge
        message.capacity = measured.capacity
        message.design_capacity = measured.design_capacity
        message.percentage = measured.percentage
        message.power_supply_status = int(measured.status)
        message.cell_voltage = list(measured.cell_voltages)
        message.cell_temperature = list(measured.cell_temperatures)
        return message


def map_message(grid: Occupancy, stamp: Time) -> OccupancyGrid:
    """The nav_msgs/OccupancyGrid of a room."""
    message = OccupancyGrid(data=array("b", np.where(grid.occupied, 100, 0).astype(np.int8).tobytes()))
    message.header.frame_id = MAP
    message.header.stamp = message.info.map_load_time = stamp
    message.info.resolution = CELL
    message.info.height, message.info.width = grid.occupied.shape
    message.info.origin.position.x, message.info.origin.position.y = grid.x, grid.y
    return message


def diagnostics_message(
    name: str, level: Level, message: str, values: Mapping[str, str], stamp: Time
) -> DiagnosticArray:
    """One status for `/diagnostics`."""
    array = DiagnosticArray(status=[status_message(name, level, message, values)])
    array.header.stamp = stamp
    return array
