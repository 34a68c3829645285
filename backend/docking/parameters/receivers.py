"""The infrared receivers and the beacon."""

from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.parameter import number


@dataclass(frozen=True, slots=True)
class Receivers:
    """Parameters of the infrared receivers and the beacon."""

    infrared_receiver_x: float = number(
        0.15, -1.0, 1.0, "m", "Position of the three infrared receivers: x in base_link."
    )
    infrared_receiver_angle: float = number(
        0.349, 0.05, 1.5, "rad", "Angle between straight ahead and the direction of the left or the right receiver."
    )
    infrared_field_of_view: float = number(
        0.5, 0.1, 3.0, "rad", "Field of view of each receiver, edge to edge. Not below infrared_receiver_angle."
    )
    infrared_beacon_angle: float = number(
        1.047,
        0.1,
        1.57,
        "rad",
        "Angle from the dock's axis to each edge of the beacon's light; the robot locates the axis by this edge.",
    )
    infrared_range_noise: float = number(
        0.03, 0.001, 1.0, "m", "Standard deviation of the measured distance to the beacon."
    )
    infrared_scan_speed: float = number(
        0.6,
        0.05,
        2.0,
        "rad/s",
        "Angular velocity while the robot turns back and forth in front of the beacon; slower is more accurate.",
    )
    infrared_distance_min: float = number(
        0.45,
        0.2,
        5.0,
        "m",
        "Minimum distance from the receivers to the beacon while the robot drives around the dock.",
    )
    infrared_distance_max: float = number(
        0.9, 0.3, 5.0, "m", "Maximum distance there. At least 0.1 m above infrared_distance_min."
    )
    infrared_last_scan: float = number(
        0.4,
        0.1,
        3.0,
        "m",
        "Distance from the docked pose at which the robot looks for the beacon's direction once more.",
    )
    infrared_axis_error_max: float = number(
        0.044,
        0.005,
        0.2,
        "rad",
        "Standard deviation of the dock's axis above which the robot does not drive onto the dock, but looks for the "
        "other edge of the light.",
    )
    infrared_scale_error: float = number(
        0.05,
        0.0,
        0.5,
        "",
        "Standard deviation of the error of odometry's distances and turns, as a fraction (slip, wheel radius).",
    )
    infrared_curve_error: float = number(
        0.1,
        0.0,
        1.0,
        "rad/m",
        "Standard deviation of the error of odometry's heading per metre (wheels that differ).",
    )

    @property
    def half(self) -> float:
        """From the middle of a receiver's view to its edges, in rad."""
        return 0.5 * self.infrared_field_of_view

    @property
    def directions(self) -> tuple[float, float, float]:
        """The directions of the left, the center and the right one, in rad to the left of straight ahead."""
        return self.infrared_receiver_angle, 0.0, -self.infrared_receiver_angle

    def position(self, robot: Pose) -> Pose:
        """Return the pose of the receivers, in the frame of the robot's pose."""
        return robot.compose(Pose(self.infrared_receiver_x))
