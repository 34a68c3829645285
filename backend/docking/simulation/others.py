"""The other robots in the room: where they are, as they say themselves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from docking.core.footprint import ROBOT_RADIUS
from docking.simulation.obstacle import Obstacle

SILENT = 5.0
"""Seconds after which a robot that says nothing has gone."""


@dataclass(frozen=True, slots=True)
class _Heard:
    x: float
    y: float
    at: float


class Others:
    """Remembers where other robots are, and forgets those that say nothing any more."""

    def __init__(self) -> None:
        """Begin with none."""
        self._heard: dict[str, _Heard] = {}

    def hear(self, name: str, x: float, y: float, now: float) -> None:
        """Take up where a robot is.

        Args:
            name: The robot.
            x: base_link in world, in m.
            y: The same.
            now: Seconds of a clock that never jumps.
        """
        self._heard[name] = _Heard(x, y, now)

    def bodies(self, now: float) -> tuple[Obstacle, ...]:
        """Return those that are there. The camera sees over them.

        Args:
            now: Seconds of the same clock.
        """
        self._heard = {name: heard for name, heard in self._heard.items() if now - heard.at <= SILENT}
        return tuple(Obstacle(heard.x, heard.y, ROBOT_RADIUS, low=True) for heard in self._heard.values())


def not_pushing(bodies: Sequence[Obstacle], x: float, y: float, radius: float) -> tuple[Obstacle, ...]:
    """Return bodies that do not push a robot: one that overlaps with it ends where the robot begins.

    What is known of another robot is a moment old, so that it may seem to have driven into this one.

    Args:
        bodies: Other robots.
        x: The middle of this robot's body, in world.
        y: The same.
        radius: Of this robot, in m.
    """
    beside = ((body, math.hypot(body.x - x, body.y - y) - radius) for body in bodies)
    return tuple(
        body if distance >= body.radius else replace(body, radius=distance)
        for body, distance in beside
        if distance > 0.0
    )
