"""Computes velocities with which the robot comes to a standstill where it is to.

The smooth control law, `steer`, is that of J. J. Park and B. Kuipers, "A smooth control law for graceful motion of
differential wheeled mobile robots in 2D environment", IEEE International Conference on Robotics and Automation (ICRA),
2011, equations 1, 13, 14 and 15. nav2's docking server and graceful controller use the same law.
"""

import math
from dataclasses import dataclass

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Velocity
from docking.parameters import Gains, MotionLimits
from docking.parameters.limits import braked

STRAIGHT = Gains(k_phi=1.0, k_delta=1.0)
"""For a way that is straight but for small errors."""
TURN_FIRST = math.radians(30.0)
"""The heading error that is corrected on the spot, before the robot drives."""


@dataclass(frozen=True, slots=True)
class Steering:
    """The output of the control law.

    Attributes:
        curvature: Of the way, in 1/m; to the left is positive.
        slowness: Divisor of the highest speed, at least 1.
    """

    curvature: float
    slowness: float


def steer(robot: Pose, target: Pose, gains: Gains) -> Steering:
    """Return how to drive forward, so that the robot gets to the target and is turned like it there.

    Args:
        robot: Where the robot is.
        target: Where it is to be, in the same frame; a robot that is there already goes straight on.
        gains: The constants; the paper's k1 and k2 are nav2's k_phi and k_delta.
    """
    distance = robot.distance_to(target)
    if distance < 1e-3:
        return Steering(0.0, 1.0)
    line_of_sight = math.atan2(target.y - robot.y, target.x - robot.x)
    theta = normalize_angle(target.theta - line_of_sight)
    delta = normalize_angle(robot.theta - line_of_sight)
    heading_error = delta - math.atan(-gains.k_phi * theta)
    change = 1.0 + gains.k_phi / (1.0 + (gains.k_phi * theta) ** 2)
    curvature = -(gains.k_delta * heading_error + change * math.sin(delta)) / distance
    return Steering(curvature, 1.0 + gains.beta * abs(curvature) ** gains.lambda_)


def turn(error: float, motion: MotionLimits) -> Velocity:
    """On the spot, by `error` rad."""
    return Velocity(0.0, bounded(braked(error, motion.a_angular_max), motion.v_angular_max))


def drive_to(robot: Pose, target: Pose, motion: MotionLimits, *, forwards: bool = False) -> Velocity:
    """Straight to a point, forwards or backwards, whichever is the smaller turn; on the spot while turned away.

    Args:
        robot: Where the robot is.
        target: Where it is to be, in the same frame; how it is turned there does not matter.
        motion: Limits of the robot's motion.
        forwards: Whether to drive forwards in any case.
    """
    direction = math.atan2(target.y - robot.y, target.x - robot.x)
    error = normalize_angle(direction - robot.theta)
    backwards = not forwards and abs(error) > 0.5 * math.pi
    if backwards:
        error = normalize_angle(error + math.pi)
    if abs(error) > TURN_FIRST:
        return turn(error, motion)
    # Backwards, the law is that of a robot which is turned round.
    turned = Pose(robot.x, robot.y, direction - error)
    steering = steer(turned, Pose(target.x, target.y, direction), STRAIGHT)
    speed = min(motion.v_linear_max / steering.slowness, braked(robot.distance_to(target), motion.a_linear_max))
    return Velocity(-speed if backwards else speed, bounded(steering.curvature * speed, motion.v_angular_max))


def bounded(value: float, most: float) -> float:
    """The nearest value between -most and most."""
    return min(max(value, -most), most)
