"""The parameters of the action servers. A new parameter is one more field here; see `core.parameter`."""

import enum
from dataclasses import dataclass, replace

from docking.core.footprint import ROBOT_RADIUS, Footprint, read_footprint, round_footprint
from docking.core.geometry import Pose
from docking.core.parameter import NodeSettings, choice, group, number, string, switch

BACKWARDS = 0.6
"""The part of v_linear_max that the robot backs with: it does not see where it goes."""


class GoalPolicy(enum.StrEnum):
    """What happens to a goal that arrives while another one runs."""

    REJECT = "reject"
    PREEMPT = "preempt"


class ControllerName(enum.StrEnum):
    """What drives the robot to its dock."""

    ROTATE = "rotate"
    DOCK_POSE = "dock_pose"
    INFRARED = "infrared"


@dataclass(frozen=True)
class Timeouts:
    """Time limits of every goal."""

    battery_stale_after: float = number(
        2.0,
        0.1,
        3600.0,
        "s",
        "Time without a battery message after which the wheels stop; the goal continues with the next message.",
    )
    battery_lost_after: float = number(
        60.0,
        0.1,
        86400.0,
        "s",
        "Time without a battery message, counted from the goal's acceptance, after which it is aborted. "
        "Not below battery_stale_after.",
    )
    goal_timeout: float = number(
        0.0, 0.0, 86400.0, "s", "Maximum duration of a goal, after which it is aborted; 0: no limit."
    )
    odometry_timeout: float = number(
        1.0, 0.1, 60.0, "s", "Time without odometry after which the goal is aborted; does not apply to rotate."
    )
    blocked_after: float = number(
        2.0,
        0.5,
        60.0,
        "s",
        "Time over which commanded and measured motion are compared; if they differ too much, the robot is blocked.",
    )


@dataclass(frozen=True)
class DockTimeouts(Timeouts):
    """Time limits and retries of a docking goal."""

    initial_perception_timeout: float = number(20.0, 0.1, 3600.0, "s", "Time limit for finding the dock.")
    staging_timeout: float = number(60.0, 0.1, 3600.0, "s", "Time limit for driving to the staging pose.")
    dock_approach_timeout: float = number(
        30.0, 0.1, 3600.0, "s", "Time limit for driving from the staging pose to the dock."
    )
    wait_charge_timeout: float = number(
        5.0, 0.1, 3600.0, "s", "Time limit for the battery to start charging on the dock."
    )
    charge_stable_for: float = number(
        1.0,
        0.0,
        60.0,
        "s",
        "Time for which the battery must charge without a break until the goal succeeds; meanwhile the robot goes on "
        "to the docked pose. With rotate, the first battery message counts, as in the tutorial.",
    )
    retry_timeout: float = number(30.0, 0.1, 3600.0, "s", "Time limit for backing off.")
    max_retries: int = number(3, 0, 100, "", "Maximum number of retries; the robot backs off before each of them.")


@dataclass(frozen=True)
class UndockTimeouts(Timeouts):
    """Time limits of an undocking goal."""

    undocking_timeout: float = number(
        20.0, 0.1, 3600.0, "s", "Time limit for backing out until the battery no longer charges."
    )


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """What the robot may do. It stands still or moves between the minimum and the maximum velocities."""

    v_linear_max: float = number(
        0.26, 0.01, 2.0, "m/s", "Maximum linear velocity, forwards and backwards (linear.x). Not below v_linear_min."
    )
    v_linear_min: float = number(
        0.04,
        0.005,
        0.5,
        "m/s",
        "Minimum linear velocity: slower commands may not move the base. Also used for the last part before contact.",
    )
    v_angular_max: float = number(
        1.0, 0.05, 4.0, "rad/s", "Maximum angular velocity, in both directions (angular.z). Not below v_angular_min."
    )
    v_angular_min: float = number(
        0.0, 0.0, 1.0, "rad/s", "Minimum angular velocity of a turn on the spot: slower commands may not move the base."
    )
    a_linear_max: float = number(0.5, 0.05, 5.0, "m/s²", "Maximum linear acceleration; does not apply to a stop.")
    a_angular_max: float = number(2.0, 0.1, 20.0, "rad/s²", "Maximum angular acceleration; does not apply to a stop.")

    @property
    def v_linear_back(self) -> float:
        """Linear velocity while the robot backs out, in m/s."""
        return max(self.v_linear_min, BACKWARDS * self.v_linear_max)


@dataclass(frozen=True, slots=True)
class Staging:
    """Where the staging pose is."""

    staging_x_offset: float = number(
        -0.7,
        -3.0,
        -0.3,
        "m",
        "Distance from the docked pose to the staging pose along the robot's x axis; negative is in front of the dock.",
    )

    @property
    def distance(self) -> float:
        """Between the docked pose and the staging pose, in m."""
        return -self.staging_x_offset

    def staging(self, docked: Pose) -> Pose:
        """Where base_link waits in front of the dock, turned towards it."""
        return docked.compose(Pose(self.staging_x_offset))


@dataclass(frozen=True, slots=True)
class Dock(Staging):
    """Where base_link stands when docked, and where it waits in front. The names are nav2's."""

    external_detection_translation_x: float = number(
        -0.2,
        -2.0,
        0.0,
        "m",
        "Position of the docked robot relative to the marker or the beacon, along the marker's x axis, "
        "which points into the dock.",
    )
    external_detection_translation_y: float = number(0.0, -1.0, 1.0, "m", "The same, along the marker's y axis.")
    external_detection_rotation_yaw: float = number(
        0.0, -3.1416, 3.1416, "rad", "Heading of the docked robot relative to the marker's x axis."
    )

    def docked(self, marker: Pose) -> Pose:
        """Where base_link is when docked, in the frame that the marker's pose is given in."""
        return marker.compose(
            Pose(
                self.external_detection_translation_x,
                self.external_detection_translation_y,
                self.external_detection_rotation_yaw,
            )
        )


@dataclass(frozen=True, slots=True)
class Gains:
    """Constants of the smooth control law, with nav2's names."""

    k_phi: float = number(
        3.0,
        0.1,
        20.0,
        "",
        "How hard the robot steers towards the line that leads straight onto the dock, as a ratio of rates.",
    )
    k_delta: float = number(2.0, 0.1, 20.0, "", "How much faster its heading converges than its way.")
    beta: float = number(
        0.4,
        0.0,
        10.0,
        "",
        "How much it slows down in curves: v = v_linear_max / (1 + beta * abs(curvature) ** lambda).",
    )
    lambda_: float = number(2.0, 0.1, 10.0, "", "How sharply it slows down in curves, see beta.")


@dataclass(frozen=True, slots=True)
class ApproachSettings:
    """How the robot drives from the staging pose onto the dock."""

    gains: Gains = group(Gains)
    slowdown_radius: float = number(
        0.06, 0.0, 1.0, "m", "The last part of the approach, which is driven at v_linear_min."
    )
    docking_threshold: float = number(
        0.05,
        0.005,
        0.5,
        "m",
        "Distance from the docked pose within which a robot whose wheels have stopped is taken to be docked.",
    )
    docking_overshoot: float = number(
        0.015,
        0.0,
        0.2,
        "m",
        "Distance beyond the docked pose that is driven without a contact, before the robot is taken to be docked.",
    )
    docking_lateral_tolerance: float = number(
        0.02,
        0.002,
        0.2,
        "m",
        "Maximum lateral error on the last 6 cm; with more, the robot backs off and retries. Before that, it stands "
        "still and looks until it knows the docked pose to 0.3 of this and of docking_heading_tolerance.",
    )
    docking_heading_tolerance: float = number(
        0.0873, 0.01, 0.8, "rad", "Maximum heading error there; with more, the robot backs off and retries."
    )
    look_timeout: float = number(
        10.0, 0.0, 600.0, "s", "Maximum time for that; then the robot drives on with what it knows."
    )
    blind_distance: float = number(
        0.15,
        0.0,
        1.0,
        "m",
        "Distance from the docked pose within which the robot drives on without seeing the dock.",
    )


@dataclass(frozen=True, slots=True)
class Receivers:
    """How the infrared receivers are mounted and what the beacon is like."""

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
        """Where the left, the center and the right one look, in rad to the left of straight ahead."""
        return self.infrared_receiver_angle, 0.0, -self.infrared_receiver_angle

    def position(self, robot: Pose) -> Pose:
        """Where they are, in the frame of the robot's pose."""
        return robot.compose(Pose(self.infrared_receiver_x))


@dataclass(frozen=True)
class ServerSettings(NodeSettings):
    """What both action servers have."""

    goal_policy: GoalPolicy = choice(
        GoalPolicy.REJECT,
        "What happens to a goal that arrives while another one runs: it is rejected, or it preempts the "
        "other one, which is aborted.",
    )
    autostart: bool = switch(
        True,
        "Whether the node configures and activates itself at its start; if not, `ros2 lifecycle set` or a manager "
        "does.",
    )
    timeouts: Timeouts = group(Timeouts)
    controller_frequency: float = number(
        20.0, 5.0, 100.0, "Hz", "Rate at which velocities are computed and published; rotate publishes at 10 Hz."
    )
    motion: MotionLimits = group(MotionLimits)

    @property
    def control_period(self) -> float:
        """Seconds between two velocities."""
        return 1.0 / self.controller_frequency

    def find_conflict(self) -> str | None:
        """Why these values cannot work together."""
        timeouts, motion = self.timeouts, self.motion
        return (
            _order(
                "battery_lost_after", timeouts.battery_lost_after, "battery_stale_after", timeouts.battery_stale_after
            )
            or _order("v_linear_max", motion.v_linear_max, "v_linear_min", motion.v_linear_min)
            or _order("v_angular_max", motion.v_angular_max, "v_angular_min", motion.v_angular_min)
        )

    def _backing(self, name: str, timeout: float, distance: float) -> str | None:
        speed = self.motion.v_linear_back
        where = f"{distance:g} m (staging_x_offset) backwards at {speed:.3g} m/s ({BACKWARDS:g} of v_linear_max)"
        return _duration(name, timeout, distance / speed, where)


@dataclass(frozen=True)
class DockSettings(ServerSettings):
    """The parameters of the docking action server."""

    timeouts: DockTimeouts = group(DockTimeouts)
    controller: ControllerName = choice(
        ControllerName.ROTATE,
        "How the robot is driven: turning on the spot as in the tutorial, by the pose of a marker on the "
        "dock, or by three infrared receivers. Of the parameters about motion, rotate uses rotate_speed alone.",
    )
    rotate_speed: float = number(
        0.15,
        -2.0,
        2.0,
        "rad/s",
        "Angular velocity of the controller rotate (angular.z); counter-clockwise is positive.",
    )
    search_speed: float = number(
        0.6, 0.05, 4.0, "rad/s", "Angular velocity while the robot searches for the dock. Not below v_angular_min."
    )
    external_detection_timeout: float = number(
        2.0,
        0.1,
        60.0,
        "s",
        "Time without a detection of the marker or the beacon, during the approach, after which the dock is lost.",
    )
    dock: Dock = group(Dock)
    approach: ApproachSettings = group(ApproachSettings)
    receivers: Receivers = group(Receivers)
    robot_radius: float = number(
        ROBOT_RADIUS, 0.01, 5.0, "m", "Radius of a round robot, around base_link; for maps only."
    )
    footprint: str = string(
        "",
        "[[x, y], …]",
        "Outline of a robot that is not round: 3 to 100 points in base_link, in m, in their order around the robot. "
        "If it is empty, robot_radius counts.",
        read_footprint,
    )

    @property
    def goal_timeouts(self) -> DockTimeouts:
        """The time limits of a goal with this controller."""
        if self.controller is ControllerName.ROTATE:
            return replace(self.timeouts, charge_stable_for=0.0)
        return self.timeouts

    @property
    def outline(self) -> Footprint:
        """The robot from above, in base_link."""
        return read_footprint(self.footprint) or round_footprint(self.robot_radius)

    def find_conflict(self) -> str | None:
        """Why these values cannot work together."""
        receivers, motion = self.receivers, self.motion
        conflict = super().find_conflict() or _order(
            "infrared_field_of_view",
            receivers.infrared_field_of_view,
            "infrared_receiver_angle",
            receivers.infrared_receiver_angle,
        )
        if conflict is None and receivers.infrared_distance_max < receivers.infrared_distance_min + 0.1:
            conflict = (
                f"infrared_distance_max ({receivers.infrared_distance_max:g} m) must be at least 0.1 m above"
                f" infrared_distance_min ({receivers.infrared_distance_min:g} m)"
            )
        if conflict is not None or self.controller is ControllerName.ROTATE:
            return conflict
        distance, timeouts = self.dock.distance, self.timeouts
        slow = min(distance, self.approach.slowdown_radius)
        fast = distance - slow
        where = (
            f"{fast:.3g} m at {motion.v_linear_max:g} m/s (v_linear_max)"
            f" and {slow:g} m at {motion.v_linear_min:g} m/s (v_linear_min)"
        )
        approach = fast / motion.v_linear_max + slow / motion.v_linear_min
        return (
            _order("search_speed", self.search_speed, "v_angular_min", motion.v_angular_min)
            or _duration("dock_approach_timeout", timeouts.dock_approach_timeout, approach, where)
            or self._backing("retry_timeout", timeouts.retry_timeout, distance)
        )


@dataclass(frozen=True)
class UndockSettings(ServerSettings):
    """The parameters of the undocking action server."""

    timeouts: UndockTimeouts = group(UndockTimeouts)
    assume_docked: bool = switch(
        False,
        "Whether a robot backs out although nothing tells that it is docked: for bases whose battery never tells that "
        "it charges. If it is false, the goal is aborted (DOCKED_UNKNOWN).",
    )
    staging: Staging = group(Staging)

    def find_conflict(self) -> str | None:
        """Why these values cannot work together."""
        return super().find_conflict() or self._backing(
            "undocking_timeout", self.timeouts.undocking_timeout, self.staging.distance
        )


def _order(greater: str, high: float, smaller: str, low: float) -> str | None:
    return None if high >= low else f"{greater} ({high:g}) must not be below {smaller} ({low:g})"


def _duration(name: str, timeout: float, needed: float, where: str) -> str | None:
    return None if needed <= timeout else f"{name} ({timeout:g} s) is too short: {where} takes {needed:.1f} s"
