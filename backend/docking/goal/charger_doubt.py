"""Doubts a charge that the robot carries along, or that is away from the dock."""

import math

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.goal.charging import moves
from docking.goal.dock_memory import MOVED, TURNED

ELSEWHERE = 0.3
"""How far from the docked pose, in m, no charger is."""


class ChargerDoubt:
    """Judges a battery that says that it charges by where the robot is, and by whether it drives.

    Attributes:
        reason: Why a charge was not believed in this goal, as a sentence; empty where it always was.
    """

    def __init__(self) -> None:
        """Begin without a charge."""
        self.reason = ""
        self._began: Pose | None = None  # where the robot was when the battery began to say so
        self._carried = False

    def believes(self, robot: Pose | None, velocity: Velocity, docked: Pose | None, *, charges: bool) -> bool:
        """Take notice of a battery message, and say whether its charge is believed.

        A charge that has driven along is not believed before the battery has said once that it does not charge. Near
        its dock the robot may drive on along the contacts.

        Args:
            robot: base_link in odom; None without odometry, as with `rotate`: the battery is then believed.
            velocity: Of the robot.
            docked: Where base_link is when docked, in odom; None where that is not known.
            charges: Whether the message says that the battery charges.
        """
        if not charges:
            self._began, self._carried = None, False
            return False
        if robot is None:
            return True
        self._began = self._began or robot
        off = robot.relative_to(self._began)
        way, away = math.hypot(off.x, off.y), 0.0 if docked is None else robot.distance_to(docked)
        if docked is not None and away <= ELSEWHERE and not self._carried:
            self._began = robot  # long contacts charge while the robot goes on to its docked pose
        elif way > MOVED or abs(off.theta) > TURNED:
            self._carried = True
            self.reason = (
                f"the battery said that it charges while the robot moved by {way:.1f} m and"
                f" {math.degrees(abs(off.theta)):.0f} degrees: that is not believed"
            )
        elif away > ELSEWHERE and not self._carried:
            self.reason = f"the battery said that it charges {away:.1f} m from the dock: that is not believed"
        return not (self._carried or moves(velocity) or away > ELSEWHERE)
