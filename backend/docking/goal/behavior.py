"""The interface of behaviors, which compute the next velocity. Plain Python, without ROS."""

from dataclasses import dataclass
from typing import Protocol

from docking.core.errors import DockingError
from docking.core.observation import Observation, Velocity


@dataclass(frozen=True, slots=True)
class Done:
    """The robot is where the controller was to bring it, and is to stand still."""


@dataclass(frozen=True, slots=True)
class Failed:
    """The controller cannot go on from here; the robot is to stand still.

    Attributes:
        error: Why.
    """

    error: DockingError


Step = Velocity | Done | Failed


class Behavior(Protocol):
    """Computes the next velocity; a new one is made for each attempt."""

    def step(self, observation: Observation, dt: float) -> Step:
        """Return the velocity until the next step, or the end of the behavior.

        Args:
            observation: Current sensor readings.
            dt: Seconds since the last step; 0 at the first one.
        """


class Fail:
    """The behavior for a robot that cannot go on: fails at once."""

    def __init__(self, error: DockingError) -> None:
        self._failed = Failed(error)

    def step(self, observation: Observation, dt: float) -> Failed:
        """Return the error."""
        return self._failed
