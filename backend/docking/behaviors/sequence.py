"""Several controllers one after another."""

from collections.abc import Callable

from docking.core.observation import STANDSTILL, Observation
from docking.goal.behavior import Behavior, Done, Step


class Sequence:
    """Done when the last one is; each is made when its turn comes."""

    def __init__(self, *makers: Callable[[], Behavior]) -> None:
        self._makers = list(makers)
        self._current: Behavior | None = None

    def step(self, observation: Observation, dt: float) -> Step:
        """What the one whose turn it is says; a standstill between two."""
        if self._current is None:
            if not self._makers:
                return Done()
            self._current = self._makers.pop(0)()
        step = self._current.step(observation, dt)
        if isinstance(step, Done) and self._makers:
            self._current = None
            return STANDSTILL
        return step
