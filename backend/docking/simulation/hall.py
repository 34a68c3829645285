"""The hall of a simulated fleet: one room for all robots, with docks along a wall and a start place for each robot."""

from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED

LANE = 1.0
"""Between two docks, and between two robots that start beside each other, in m."""
LANES_IN_WORKSHOP = 6
"""How many have room in the workshop as it is."""
START, ROW = -2.2, 2.0
"""Where along x the first row of robots starts, and how far behind it the second one, in m."""


@dataclass(frozen=True, slots=True)
class Hall:
    """A hall. Robots and docks are counted from 1.

    Attributes:
        robots: How many robots there are.
        docks: How many docks; at most one for each robot.
    """

    robots: int
    docks: int

    @property
    def dock_names(self) -> tuple[str, ...]:
        """The names of the docks: `dock1`, `dock2`, and so on."""
        return tuple(f"dock{number}" for number in range(1, self.docks + 1))

    @property
    def dock_places(self) -> tuple[float, ...]:
        """Where the docks are along y, in world, in m; the first one is at 0."""
        return tuple(_lane(index) for index in range(self.docks))

    @property
    def room_extension(self) -> float:
        """How much longer than the workshop the room is, in m."""
        return LANE * max(0, self._lanes - LANES_IN_WORKSHOP)

    def docked(self, dock: int) -> Pose:
        """base_link of a robot on a dock, in world."""
        return Pose(DOCKED.x, _lane(dock - 1), DOCKED.theta)

    def home(self, robot: int) -> int:
        """The dock that a robot uses by default; robots share one where there are fewer docks than robots."""
        return (robot - 1) % self.docks + 1

    def start(self, robot: int) -> Pose:
        """Where a robot stands at first, in world."""
        row, lane = divmod(robot - 1, self._lanes)
        return Pose(START - ROW * row, _lane(lane), 0.0)

    @property
    def _lanes(self) -> int:
        """How many robots or docks stand beside each other: robots start in two rows at most."""
        return max(self.docks, min(self.robots, LANES_IN_WORKSHOP), (self.robots + 1) // 2)


def _lane(index: int) -> float:
    """Where a lane is along y, in m: two are to the right of the first one, all others to its left."""
    return LANE * (0, 1, -1, 2, -2)[index] if index < 5 else LANE * (index - 2)
