"""The sensor readings of one moment: the input of controllers and of goals. Plain data, without ROS.

Frames: `odom` is where the robot was when odometry began, and drifts; `base_link` is the robot (x forward, y left).
All moments are seconds of the monotonic clock.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from docking.core.battery import BatteryReading
from docking.core.geometry import Pose


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity of the robot in its own frame (base_link, REP-103: x forward, z up).

    Attributes:
        linear_x: Forward, in m/s.
        angular_z: Counter-clockwise, in rad/s.
        linear_y: To the left, in m/s: omnidirectional bases only.
    """

    linear_x: float = 0.0
    angular_z: float = 0.0
    linear_y: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether it is a velocity at all: neither NaN nor infinite."""
        return math.isfinite(self.linear_x) and math.isfinite(self.angular_z) and math.isfinite(self.linear_y)

    def times(self, share: float) -> "Velocity":
        """The velocity on the same way that is slower or faster by a factor."""
        return Velocity(share * self.linear_x, share * self.angular_z, share * self.linear_y)


STANDSTILL = Velocity()


@dataclass(frozen=True, slots=True)
class Deceleration:
    """The deceleration of the base that was seen.

    Attributes:
        linear_x: In m/s².
        angular_z: In rad/s².
    """

    linear_x: float = math.inf
    angular_z: float = math.inf


UNLIMITED = Deceleration()


@dataclass(frozen=True, slots=True)
class Odometry:
    """The robot's pose and motion by its own reckoning (nav_msgs/Odometry).

    Attributes:
        pose: Of base_link in odom.
        velocity: As measured, in base_link.
        stamp: When it was measured.
    """

    pose: Pose
    velocity: Velocity
    stamp: float


@dataclass(frozen=True, slots=True)
class MarkerDetection:
    """The marker on the dock as it was seen (geometry_msgs/PoseStamped on `detected_dock_pose`).

    Attributes:
        pose: Of the marker in odom; its x axis points into the dock, the way the robot drives to get there.
        stamp: When it was seen.
        camera: Where it was seen from, in odom; None where that is not known.
    """

    pose: Pose
    stamp: float
    camera: Pose | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class InfraredReading:
    """The distances from the three receivers at the robot's front to the dock's beacon (sensor_msgs/Range).

    Attributes:
        left: In m; infinite where nothing is seen (REP-117). The receiver that is turned to the left.
        center: The same for the one that looks ahead.
        right: The same for the one that is turned to the right.
        stamp: The oldest of the three.
    """

    left: float
    center: float
    right: float
    stamp: float


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """A scan of a laser scanner (sensor_msgs/LaserScan).

    Attributes:
        points: In odom, in m; shape (n, 2).
        stamp: When it was measured.
    """

    points: npt.NDArray[np.float64]
    stamp: float


@dataclass(frozen=True, slots=True)
class Joint:
    """A driven joint, such as that of a wheel (sensor_msgs/JointState).

    Attributes:
        velocity: In rad/s.
        effort: In N·m.
        stamp: When it was measured.
    """

    velocity: float
    effort: float
    stamp: float


@dataclass(frozen=True, slots=True)
class Observation:
    """All that is known now; None for what has never come.

    Attributes:
        now: The moment.
        battery: The latest reading.
        odometry: The latest.
        marker: The latest detection, however old.
        infrared: The latest reading.
        scan: The latest.
        other_markers: Detections shortly before `marker`, the oldest first: two tags may be detected in one image.
        expected_dock: Where the docked robot is at the goal's dock, looking into it, in odom, by the dock's pose in the
            database; None where that is not known.
        localized_at: When the localization that says so was heard last.
        localization_error: Its standard deviation, in m; NaN where it does not say.
        joints: The joints that tell whether the wheels stall, by name.
        braking: How fast the base slows down at most, where it is weaker than commanded.
    """

    now: float
    battery: BatteryReading | None = None
    odometry: Odometry | None = None
    marker: MarkerDetection | None = None
    infrared: InfraredReading | None = None
    scan: Scan | None = None
    other_markers: tuple[MarkerDetection, ...] = ()
    expected_dock: Pose | None = None
    localized_at: float = -math.inf
    localization_error: float = math.nan
    joints: Mapping[str, Joint] = field(default_factory=dict)
    braking: Deceleration = UNLIMITED
