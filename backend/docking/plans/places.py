"""From where to look for a dock: in front of where it should be, else all around."""

import math
from collections.abc import Iterator

from docking.core.geometry import Pose

BODY = 0.35
"""From the docked pose to the middle of the dock's body, in m; the robot drives around that."""
DETOUR = 1.0
"""How far from there, in m."""
IN_FRONT = math.radians(120.0)
"""From how far around the dock the staging pose is reached straight: the dock looks to 180 degrees."""
AROUND = math.radians(60.0)
"""How far to get around the dock with one straight way."""
STEP = 1.0
"""Between two circles of places, in m."""
APART = 1.3
"""Between two places on a circle, in m, at most."""
INSIDE = 0.1
"""How far within the radius of the search the places stay, in m."""
FARTHEST_IN_VIEW, WIDEST_IN_VIEW = 4.0, math.radians(75.0)
"""How far from the dock, and from its axis, it can be seen at all, in m and rad."""


def way_to_front(robot: Pose, docked: Pose, staging: Pose) -> Iterator[Pose]:
    """Straight ways to the staging pose that lead around the dock.

    Args:
        robot: Where the robot is, in odom.
        docked: Where it is when docked, looking into the dock.
        staging: Where it ends.
    """
    middle = docked.compose(Pose(BODY))
    seen = robot.relative_to(middle)
    angle, distance = math.atan2(seen.y, seen.x), math.hypot(seen.x, seen.y)
    side = math.copysign(1.0, angle)
    if distance < DETOUR and abs(angle) < IN_FRONT:
        yield _around(middle, angle)
    while abs(angle) < IN_FRONT:
        angle = side * min(abs(angle) + AROUND, IN_FRONT)
        yield _around(middle, angle)
    yield staging


def _around(middle: Pose, angle: float) -> Pose:
    return middle.compose(Pose(DETOUR * math.cos(angle), DETOUR * math.sin(angle)))


def may_be_seen(robot: Pose, docked: Pose) -> bool:
    """Whether a dock can be in view of a robot that looks at it.

    Args:
        robot: Where the robot is, in odom.
        docked: Where it is when docked, looking into the dock.
    """
    seen = robot.relative_to(docked)
    return math.hypot(seen.x, seen.y) < FARTHEST_IN_VIEW and abs(math.atan2(seen.y, -seen.x)) < WIDEST_IN_VIEW


def circles(start: Pose, radius: float) -> Iterator[Pose]:
    """Places all around, on larger and larger circles.

    Args:
        start: In the middle, in odom; the first place is straight ahead.
        radius: How far away the farthest are at most, in m.
    """
    most = radius - INSIDE
    count = math.ceil(most / STEP - 1e-9)
    for number in range(1, count + 1):
        distance = min(number * STEP, most)
        places = max(3, math.ceil(math.tau * distance / APART))
        for place in range(places):
            angle = math.tau * place / places
            yield start.compose(Pose(distance * math.cos(angle), distance * math.sin(angle)))
