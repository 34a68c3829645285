"""The robot as seen from the infrared beacon, the dock's axis, and the errors of odometry: an extended Kalman filter.

Thrun, Burgard and Fox, Probabilistic Robotics, 2005, section 3.3.
"""

import math

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose, normalize_angle
from docking.parameters import Receivers

Vector = npt.NDArray[np.float64]

GATE = 16.0
"""Squared, in standard deviations: measurements beyond are rejected."""
ANGLE_NOISE = 0.02
"""Standard deviation of infrared_beacon_angle, in rad."""
EDGE_NOISE = 0.012
"""Standard deviation of the direction of an edge of the light, in rad."""
WAY_NOISE, DRIVING_NOISE, TURNING_NOISE = 0.01, 0.025, 0.01
"""Standard deviations of odometry's random errors: in m after 1 m, in rad after 1 m, and in rad after 1 rad."""
WORST = 5.0
"""How wrong odometry can be, in standard deviations."""
UNKNOWN = 2.0
"""Standard deviation of an axis that is not known, in rad."""

X, Y, THETA, WAY, TURN, CURVE, AXIS, ANGLE = range(8)
"""The state: base_link as seen from the beacon; by what to multiply ways and turns of odometry, and how much the robot
turns on each m, unnoticed; the way into the dock; and how far from that the light reaches to each side."""


class BeaconState:
    """The estimate, in a frame at the beacon that is turned as odom was when the beacon was found."""

    def __init__(self, receivers: Receivers, heading: float, bearing: float, deviation: float, distance: float) -> None:
        """The beacon was found.

        Args:
            receivers: How they are mounted.
            heading: Of the robot in odom, in rad.
            bearing: How far to the left of straight ahead the beacon is, in rad.
            deviation: Standard deviation of the bearing, in rad.
            distance: From the receivers to the beacon, in m.
        """
        self._receivers = receivers
        direction = heading + bearing
        seen_from = Pose(-distance * math.cos(direction), -distance * math.sin(direction), heading)
        robot = seen_from.compose(Pose(-receivers.infrared_receiver_x))
        self._mean = np.array(
            [robot.x, robot.y, robot.theta, 1.0, 1.0, 0.0, direction, receivers.infrared_beacon_angle]
        )
        scale, curve = receivers.infrared_scale_error, receivers.infrared_curve_error
        self._covariance: Vector = np.diag([0.0, 0.0, 0.0, scale, scale, curve, 0.0, 0.0]) ** 2
        along = np.array([math.cos(direction), math.sin(direction)])
        across = np.array([-along[1], along[0]])
        radial, lateral = receivers.infrared_range_noise**2, (distance * deviation) ** 2
        self._covariance[:2, :2] = radial * np.outer(along, along) + lateral * np.outer(across, across)
        self.forget_axis()

    @property
    def robot(self) -> Pose:
        """base_link as seen from the beacon."""
        return Pose(float(self._mean[X]), float(self._mean[Y]), float(self._mean[THETA]))

    @property
    def axis(self) -> float:
        """The way into the dock, in rad to the left of straight ahead."""
        return float(self._mean[AXIS] - self._mean[THETA])

    @property
    def plausible(self) -> bool:
        """Whether odometry is not worse than it can be."""
        scale, curve = self._receivers.infrared_scale_error, self._receivers.infrared_curve_error
        off = abs(self._mean[[WAY, TURN, CURVE]] - [1.0, 1.0, 0.0])
        return bool((off <= [WORST * scale, WORST * scale, WORST * curve]).all())

    def view(self, since: Pose) -> "View":
        """The beacon as the receivers see it.

        Args:
            since: Where base_link is then, in its frame of now.
        """
        robot = self.robot
        seen_from = robot.compose(self._receivers.position(since))
        return View(seen_from, seen_from.x - robot.x, seen_from.y - robot.y)

    def deviation(self, gradient: Vector) -> float:
        """The standard deviation of what has this gradient."""
        return math.sqrt(max(0.0, float(gradient @ self._covariance @ gradient)))

    def move(self, moved: Pose) -> None:
        """Odometry says that the robot moved to a pose in its last frame."""
        if moved.x == 0.0 == moved.theta:
            return
        mean = self._mean
        way = float(mean[WAY]) * moved.x
        turn = float(mean[TURN]) * moved.theta + float(mean[CURVE]) * moved.x
        heading = float(mean[THETA]) + 0.5 * turn
        cos, sin = math.cos(heading), math.sin(heading)
        change = np.eye(8)
        change[THETA, [TURN, CURVE]] = moved.theta, moved.x
        of_heading = 0.5 * change[THETA]
        of_heading[THETA] += 0.5
        change[X] -= way * sin * of_heading
        change[Y] += way * cos * of_heading
        change[X, WAY], change[Y, WAY] = moved.x * cos, moved.x * sin
        mean[X] += way * cos
        mean[Y] += way * sin
        mean[THETA] = normalize_angle(float(mean[THETA]) + turn)
        driven, turned = abs(moved.x), abs(moved.theta)
        self._covariance = change @ self._covariance @ change.T
        self._covariance[[X, Y], [X, Y]] += WAY_NOISE**2 * driven
        self._covariance[THETA, THETA] += DRIVING_NOISE**2 * driven + TURNING_NOISE**2 * turned

    def correct(self, gradient: Vector, innovation: float, variance: float, gate: float = GATE) -> bool:
        """Correct the state by a measurement, unless it is too unlikely; return whether it was accepted.

        Args:
            gradient: Gradient of the measured quantity with respect to the state.
            innovation: Measured minus expected value.
            variance: Variance of the measurement.
            gate: Squared, in standard deviations: measurements beyond are rejected.
        """
        spread = self._covariance @ gradient
        total = float(gradient @ spread) + variance
        if innovation * innovation > gate * total:
            return False
        gain = spread / total
        self._mean = self._mean + gain * innovation
        self._covariance = self._covariance - np.outer(gain, spread)
        return True

    def correct_distance(self, view: "View", distance: float, pushed: float = 0.0) -> None:
        """Correct the state by a distance to the beacon.

        Args:
            view: The beacon as it is seen now.
            distance: Distance to the beacon, in m.
            pushed: How far someone may have pushed the robot towards or away from it, in m.
        """
        gradient = view.of_distance()
        self._covariance[:2, :2] += pushed**2 * np.outer(gradient[:2], gradient[:2])
        self.correct(gradient, distance - view.distance, self._receivers.infrared_range_noise**2, gate=math.inf)

    def correct_axis(self, view: "View", side: int, line_of_sight: float, gate: float = GATE) -> bool:
        """Correct the state by an edge of the light; return whether it was accepted.

        Args:
            view: The beacon as it is seen now.
            side: Side of the edge: 1 is the right one, as seen from a robot that looks at the dock, -1 the left one.
            line_of_sight: The direction to the beacon at the edge, in rad.
            gate: Squared, in standard deviations: measurements beyond are rejected.
        """
        gradient = view.of_line_of_sight()
        gradient[AXIS] -= 1.0
        gradient[ANGLE] -= side
        innovation = normalize_angle(float(self._mean[AXIS] + side * self._mean[ANGLE]) - line_of_sight)
        return self.correct(gradient, innovation, EDGE_NOISE**2, gate)

    def axis_error(self, view: "View") -> float:
        """Standard deviation of the robot's angle off the dock's axis, in rad."""
        gradient = view.of_line_of_sight()
        gradient[AXIS] -= 1.0
        return self.deviation(gradient)

    def forget_axis(self) -> None:
        """Forget the axis: what was taken for an edge of the light cannot have been one."""
        self._mean[ANGLE] = self._receivers.infrared_beacon_angle
        for unknown, deviation in ((AXIS, UNKNOWN), (ANGLE, ANGLE_NOISE)):
            self._covariance[unknown, :] = self._covariance[:, unknown] = 0.0
            self._covariance[unknown, unknown] = deviation**2


class View:
    """The beacon as the receivers see it, and how that depends on the state.

    Attributes:
        distance: From the receivers to the beacon, in m.
        line_of_sight: The direction to it, in rad in the frame of the estimate, which does not drift as odometry does.
        bearing: How far to the left of straight ahead it is, in rad.
    """

    def __init__(self, receivers: Pose, lever_x: float, lever_y: float) -> None:
        """Look.

        Args:
            receivers: Where they are, as seen from the beacon.
            lever_x: How far they are from base_link of now, in m along the same axes.
            lever_y: The same.
        """
        self._x, self._y = receivers.x, receivers.y
        self._lever_x, self._lever_y = lever_x, lever_y
        self.distance = max(math.hypot(receivers.x, receivers.y), 1e-3)
        self.line_of_sight = math.atan2(-receivers.y, -receivers.x)
        self.bearing = normalize_angle(self.line_of_sight - receivers.theta)

    def of_distance(self) -> Vector:
        """The gradient of the distance."""
        return self._gradient(self._x / self.distance, self._y / self.distance)

    def of_line_of_sight(self) -> Vector:
        """The gradient of the line of sight."""
        return self._gradient(-self._y / self.distance**2, self._x / self.distance**2)

    def of_bearing(self) -> Vector:
        """The gradient of the bearing."""
        gradient = self.of_line_of_sight()
        gradient[THETA] -= 1.0
        return gradient

    def _gradient(self, x: float, y: float) -> Vector:
        gradient = np.zeros(8)
        gradient[:3] = x, y, y * self._lever_x - x * self._lever_y
        return gradient
