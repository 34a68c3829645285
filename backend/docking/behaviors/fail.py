"""The behavior for a robot that cannot go on."""

from docking.core.errors import DockingError
from docking.core.observation import Observation
from docking.goal.behavior import Failed


class Fail:
    """Fails at once."""

    def __init__(self, error: DockingError) -> None:
        self._failed = Failed(error)

    def step(self, observation: Observation, dt: float) -> Failed:
        """Say why."""
        return self._failed
