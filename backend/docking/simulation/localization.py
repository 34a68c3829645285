"""The robot's localization on its map: off by some centimetres, and it jumps at times."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose
from docking.core.parameter import number

RATE = 10.0
"""Poses a second."""
PAUSE, LASTS = (2.0, 8.0), (0.5, 3.0)
"""Between two jumps, and how long each lasts, in s."""
LEAST = 0.25
"""The shortest jump, as a fraction of the longest."""


@dataclass(frozen=True, slots=True)
class LocalizationSettings:
    """Properties of the localization, as they show at the dock."""

    error_x: float = number(
        0.0, -2.0, 2.0, "m", "How much farther away than it is the localization has the dock, along the dock's axis."
    )
    error_y: float = number(0.0, -2.0, 2.0, "m", "How much farther to the left it has the dock.")
    error_yaw: float = number(0.0, -1.57, 1.57, "rad", "How much farther turned to the left it has the dock.")
    noise: float = number(0.0, 0.0, 0.5, "m", "Standard deviation of the localization from one pose to the next.")
    jump: float = number(
        0.0,
        0.0,
        2.0,
        "m",
        "How far the localization jumps at most, every 2 to 8 s, for 0.5 to 3 s; a quarter of that at least; 0: never.",
    )


class Localization:
    """Says where the dock is, by the map.

    Attributes:
        off: The docked pose by the localization, as seen from where it is.
    """

    def __init__(self, settings: LocalizationSettings, random: Random) -> None:
        """Start without a jump.

        Args:
            settings: Its properties.
            random: Decides on jumps and noise.
        """
        self._settings = settings
        self._random = random
        self._jump = Pose()
        self._jumps_at = self._ends_at = self._due = 0.0
        self.off = Pose()

    def step(self, now: float, jump: float = 0.0) -> None:
        """Measure, when its time has come.

        Args:
            now: Simulated seconds.
            jump: How far it jumps at most, in m, if that is more than its settings say.
        """
        if now < self._due:
            return
        self._due = now + 1.0 / RATE
        settings, random = self._settings, self._random
        most = max(jump, settings.jump)
        if self._jumps_at == 0.0 or now >= self._jumps_at:
            if self._jumps_at > 0.0 and most > 0.0:
                way, angle = random.uniform(LEAST * most, most), random.uniform(-math.pi, math.pi)
                self._jump = Pose(way * math.cos(angle), way * math.sin(angle))
                self._ends_at = now + random.uniform(*LASTS)
            self._jumps_at = max(now, self._ends_at) + random.uniform(*PAUSE)
        if now >= self._ends_at:
            self._jump = Pose()
        self.off = Pose(
            settings.error_x + self._jump.x + random.gauss(0.0, settings.noise),
            settings.error_y + self._jump.y + random.gauss(0.0, settings.noise),
            settings.error_yaw,
        )
