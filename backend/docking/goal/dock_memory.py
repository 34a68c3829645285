"""Whether the robot is docked, as far as earlier goals can tell."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from docking.core.geometry import Pose
from docking.goal.hits import Hits
from docking.parameters import Staging

MOVED = 0.1
"""In m; a robot that odometry has moved by more is somewhere else."""
TURNED = 0.35
"""The same in rad."""
MOST = 1000
"""Docks that are remembered: goals may describe docks that have no name."""


@dataclass
class DockMemory:
    """Remembered from goal to goal, for as long as the process runs.

    Attributes:
        docked: Whether the robot was docked at the end of the last goal that tells; None where nothing is known.
        at: Where it stood then, in odom; None where that is not known.
        since: From when on it has been docked there, by the clock of observations; inf where that is not known.
        staging: Of the dock that the robot is on, else of that of the last docking goal, and the direction; None before
            the first one.
        dock_type: Of the same dock; empty where there is none.
        charges: Whether the same dock charges.
        places: Where base_link stood when it was docked last, in odom, by the names of docks.
        hits: Where the robot has run into something lately, in odom.
        turns: How far a dock's marker was taken to be turned then, in rad, by the names of docks.
    """

    docked: bool | None = None
    at: Pose | None = None
    since: float = math.inf
    staging: Staging | None = None
    dock_type: str = ""
    charges: bool = True
    places: dict[str, Pose] = field(default_factory=dict)
    turns: dict[str, float] = field(default_factory=dict)
    hits: Hits = field(default_factory=Hits)

    def docked_at(self, dock: str, place: Pose | None, turn: float) -> None:
        """Remember where the robot was docked, and how far the marker seemed to be turned.

        Args:
            dock: The name of the dock.
            place: base_link in odom; None if unknown.
            turn: Of the marker, in rad.
        """
        self.turns.pop(dock, None)  # the last ones are at the end
        self.turns[dock] = turn
        if place is not None:
            self.places.pop(dock, None)
            self.places[dock] = place
        while len(self.turns) > MOST:
            forgotten = next(iter(self.turns))
            self.turns.pop(forgotten)
            self.places.pop(forgotten, None)

    def note(self, docked: bool, at: Pose | None, now: float = math.inf) -> None:
        """Remember how a goal has ended, where, and when by the clock of observations."""
        if not (docked and self.recall(at)):
            self.since = now
        self.docked, self.at = docked, at

    def heads_for(self, staging: Staging, dock_type: str, robot: Pose | None, *, charges: bool = True) -> None:
        """A goal to dock runs: its dock is remembered, unless the robot is still on the one where it was docked last.

        Args:
            staging: Of the goal's dock.
            dock_type: Of the same dock.
            robot: Where it is now, in odom; None where that is not known yet.
            charges: Whether that dock charges.
        """
        if robot is not None and self.recall(robot) is None:
            self.docked = None  # for good: odometry drifts, so that the place may seem to be somewhere else later
        if not self.docked or self.staging is None:
            self.staging, self.dock_type, self.charges = staging, dock_type, charges

    def moves(self) -> None:
        """Forget what was known without a pose: a goal moves the robot."""
        if self.at is None:
            self.docked = None

    def type_among(self, types: Sequence[str]) -> str | None:
        """The type of the dock that the robot is on; empty where there are no types, None if it is not known."""
        if self.dock_type in types:
            return self.dock_type
        return None if len(types) > 1 else "".join(types)

    def recall(self, robot: Pose | None) -> bool | None:
        """Whether the robot is docked; None where that is not known, as when it was moved since.

        Args:
            robot: Where it is now, in odom.
        """
        if self.docked is None or self.at is None:
            return self.docked
        if robot is None:
            return None
        off = robot.relative_to(self.at)
        return self.docked if robot.distance_to(self.at) <= MOVED and abs(off.theta) <= TURNED else None
