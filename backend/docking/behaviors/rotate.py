"""The controller `rotate`: the tutorial's."""

from docking.core.observation import Observation, Velocity


class Rotate:
    """Turns on the spot, as the tutorial does, until the dock is found by luck or by hand."""

    def __init__(self, speed: float = 0.15) -> None:
        self._velocity = Velocity(0.0, speed)

    def step(self, observation: Observation, dt: float) -> Velocity:
        """The same velocity always: `speed` rad/s, counter-clockwise."""
        return self._velocity
