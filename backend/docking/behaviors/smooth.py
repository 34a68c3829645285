"""A smooth control law for unicycles.

J. J. Park and B. Kuipers, "A smooth control law for graceful motion of differential wheeled mobile robots in 2D
environment", IEEE International Conference on Robotics and Automation (ICRA), 2011, equations 1, 13, 14 and 15. nav2's
docking server and graceful controller use the same law.
"""

import math
from dataclasses import dataclass

from docking.core.geometry import Pose, normalize_angle
from docking.parameters import Gains


@dataclass(frozen=True, slots=True)
class Steering:
    """What the law says.

    Attributes:
        curvature: Of the way, in 1/m; to the left is positive.
        slowness: What to divide the highest speed by, at least 1.
    """

    curvature: float
    slowness: float


def steer(robot: Pose, target: Pose, gains: Gains) -> Steering:
    """How to drive forward, so that the robot gets to the target and is turned like it there.

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
