"""Remembers from earlier goals whether the robot is docked."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from docking.core.geometry import Pose
from docking.core.parameter import from_values
from docking.goal.hits import Hits
from docking.parameters import Dock, Staging

MOVED = 0.1
"""In m; a robot that odometry has moved by more is somewhere else."""
TURNED = 0.35
"""The same in rad."""
MOST = 1000
"""Docks that are remembered: goals may describe docks that have no name."""
MOST_RECORDED = 20
"""Those of them that a recording knows."""


@dataclass(frozen=True, slots=True)
class LastDocking:
    """The last docking at one dock.

    Attributes:
        dock: The dock's parameters then.
        place: base_link in odom; None where that is not known.
        turn: How far the marker was taken to be turned on its dock, in rad.
        camera: How far the camera was from where tf has it, in base_link; no way where nothing was measured.
    """

    dock: Staging
    place: Pose | None = None
    turn: float = 0.0
    camera: Pose = field(default_factory=Pose)

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> "LastDocking":
        """Return a docking from its values by name."""
        place = values["place"]
        dock, camera = from_values(Dock, values["dock"]), Pose(**values["camera"])
        return cls(dock, place and Pose(**place), values["turn"], camera)


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
        dockings: The last one at each dock, by its name.
        hits: Where the robot has run into something lately, in odom.
    """

    docked: bool | None = None
    at: Pose | None = None
    since: float = math.inf
    staging: Staging | None = None
    dock_type: str = ""
    charges: bool = True
    dockings: dict[str, LastDocking] = field(default_factory=dict)
    hits: Hits = field(default_factory=Hits)

    def docked_at(self, name: str, docking: LastDocking) -> None:
        """Remember how the robot was docked.

        Args:
            name: Of the dock.
            docking: How. Without a place, the place before it stays.
        """
        before = self.dockings.pop(name, docking)  # the last ones are at the end
        self.dockings[name] = replace(docking, place=docking.place or before.place)
        if len(self.dockings) > MOST:
            self.dockings.pop(next(iter(self.dockings)))

    def last_at(self, name: str, dock: Staging) -> LastDocking:
        """Return how the robot was docked the last time; with other parameters, only where.

        Args:
            name: Of the dock.
            dock: Its parameters now.
        """
        last = self.dockings.get(name, LastDocking(dock))
        return last if last.dock == dock else LastDocking(dock, last.place)

    def shifted(self, by: float) -> "DockMemory":
        """Return the memory on a clock that is ahead by some seconds."""
        return replace(self, since=self.since + by, hits=self.hits.shifted(by))

    def as_json(self, now: float) -> str:
        """Return what is remembered at this moment, on a clock that is at zero now: a replay begins with it."""
        recorded = dict(list(self.dockings.items())[-MOST_RECORDED:])
        return json.dumps(asdict(replace(self.shifted(-now), dockings=recorded)))

    @classmethod
    def from_json(cls, text: str) -> "DockMemory":
        """Return what `as_json` has recorded, on the same clock.

        Raises:
            Exception: Something else has made the text.
        """
        values = json.loads(text)
        at, staging, places = values["at"], values["staging"], values["hits"]["places"]
        return cls(
            docked=values["docked"],
            at=at and Pose(**at),
            since=values["since"],
            staging=staging and from_values(Staging, staging),
            dock_type=values["dock_type"],
            charges=values["charges"],
            dockings={name: LastDocking.from_values(each) for name, each in values["dockings"].items()},
            hits=Hits([(Pose(**place), moment) for place, moment in places]),
        )

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
        """Return whether the robot is docked; None where that is not known, as when it was moved since.

        Args:
            robot: Where it is now, in odom.
        """
        if self.docked is None or self.at is None:
            return self.docked
        if robot is None:
            return None
        off = robot.relative_to(self.at)
        return self.docked if robot.distance_to(self.at) <= MOVED and abs(off.theta) <= TURNED else None
