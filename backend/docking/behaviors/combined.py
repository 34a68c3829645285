"""Behaviors made of others."""

import math
from collections.abc import Callable
from dataclasses import replace

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Behavior, Done, Step

TURNED = Pose(theta=math.pi)


class Sequence:
    """Several behaviors one after another: done when the last one is. Each is made when its turn comes."""

    def __init__(self, *makers: Callable[[], Behavior]) -> None:
        self._makers = list(makers)
        self._current: Behavior | None = None

    def step(self, observation: Observation, dt: float) -> Step:
        """Return the step of the current behavior; a standstill between two."""
        if self._current is None:
            if not self._makers:
                return Done()
            self._current = self._makers.pop(0)()
        step = self._current.step(observation, dt)
        if isinstance(step, Done) and self._makers:
            self._current = None
            return STANDSTILL
        return step


class Reversed:
    """Lets a behavior drive the robot as if its back were its front."""

    def __init__(self, behavior: Behavior) -> None:
        self._behavior = behavior

    def step(self, observation: Observation, dt: float) -> Step:
        """Return the step of the behavior for a robot that is turned round, reversed."""
        odometry = observation.odometry
        if odometry is not None:
            velocity = _reversed(odometry.velocity)
            turned = replace(odometry, pose=odometry.pose.compose(TURNED), velocity=velocity)
            observation = replace(observation, odometry=turned)
        step = self._behavior.step(observation, dt)
        return _reversed(step) if isinstance(step, Velocity) else step


def _reversed(velocity: Velocity) -> Velocity:
    return Velocity(-velocity.linear_x, velocity.angular_z, -velocity.linear_y)
