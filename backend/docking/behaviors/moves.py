"""Simple moves: how fast to turn and to drive, so that the robot comes to a standstill where it is to."""

import math

from docking.behaviors.smooth import steer
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Velocity
from docking.parameters import Gains, MotionLimits
from docking.parameters.limits import braked

STRAIGHT = Gains(k_phi=1.0, k_delta=1.0)
"""For a way that is straight but for small errors."""
TURN_FIRST = math.radians(30.0)
"""The heading error that is corrected on the spot, before the robot drives."""


def turn(error: float, motion: MotionLimits) -> Velocity:
    """On the spot, by `error` rad."""
    return Velocity(0.0, bounded(braked(error, motion.a_angular_max), motion.v_angular_max))


def drive_to(robot: Pose, target: Pose, motion: MotionLimits, *, forwards: bool = False) -> Velocity:
    """Straight to a point, forwards or backwards, whichever is the smaller turn; on the spot while turned away.

    Args:
        robot: Where the robot is.
        target: Where it is to be, in the same frame; how it is turned there does not matter.
        motion: What the robot may do.
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
