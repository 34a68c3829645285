"""Collisions: keeps the robot out of solid objects, and records each contact with the dock."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from random import Random

from docking.simulation.box import Box
from docking.simulation.dock import DOCKED, Dock
from docking.simulation.obstacle import Obstacle, Obstruction
from docking.simulation.robot import Robot
from docking.simulation.room import Room

Solid = Box | Obstacle | Room

ON, OFF = 0.4, 0.3
"""Seconds for which the current of contacts that flicker flows, and does not."""
APART = 0.035
"""How far the robot must be from the dock, in m, for the next contact to be another one."""
ROUNDING = 1e-9
CORRECTIONS = 4
"""How often a robot is moved that stands between two things, such as in a corner."""
LIP = 0.04
"""Where the lip is, in m before the docked pose."""
RING = 0.05
"""Between two circles on which a free place is looked for, in m."""


@dataclass(frozen=True, slots=True)
class Touch:
    """The beginning of a contact between robot and dock.

    Attributes:
        time: Simulated seconds.
        speed: Of the wheels just before, in m/s.
        on_contacts: Whether the robot came onto the dock's contacts; otherwise it hit another part of the dock.
    """

    time: float
    speed: float
    on_contacts: bool


class Collisions:
    """Keeps the robot out of the dock and of obstacles.

    Attributes:
        contact: Whether the robot touches the dock's contacts.
        bumps: How often it has run into something, but for the dock while it touches the contacts.
        touches: Contacts with the dock, but for those of a robot that was set down there.
        presses: How often the robot came onto the contacts.
    """

    def __init__(self, dock: Dock, bouncing: Random, room: Room | None = None) -> None:
        """Begin with nothing touched.

        Args:
            dock: The dock.
            bouncing: Decides when a current flows over contacts that bounce.
            room: Where it stands.
        """
        self.contact = False
        self.bumps = self.presses = 0
        self.touches: list[Touch] = []
        self._dock = dock
        self._room: tuple[Box | Room, ...] = () if room is None else (*room.furniture, room)
        self._bouncing = bouncing
        self._blocked = self._at_dock = False
        self._contact_since: float | None = None
        self._lip = Lip(dock)

    def resolve(self, robot: Robot, obstacles: Sequence[Obstacle], now: float, *, driven: bool = True) -> None:
        """Keep the robot out of everything solid.

        Args:
            robot: Where it has got to.
            obstacles: Obstacles other than the dock.
            now: Simulated seconds.
            driven: Whether it drove there; else it was set down.
        """
        speed, blocked = abs(robot.linear), False
        self._lip.hold(robot, now, driven=driven)
        solids: tuple[Solid, ...] = (*self._dock.boxes, *obstacles, *self._room)
        for solid in solids:
            obstruction = solid.obstruct(*robot.body, robot.radius)
            if obstruction is not None:
                robot.block(obstruction.x, obstruction.y, obstruction.normal_x, obstruction.normal_y)
                blocked = True
        if blocked and self._room:
            _correct(robot, solids)
        self.contact = self._dock.in_contact(*robot.body, robot.theta)
        if not self.contact:
            self._contact_since = None
        elif self._contact_since is None:
            self._contact_since = now
            self.presses += 1
        if driven and blocked and not self._blocked and not self.contact:
            self.bumps += 1
        self._blocked = blocked
        self._note_touch(robot, speed, now, driven=driven)

    def _note_touch(self, robot: Robot, speed: float, now: float, *, driven: bool) -> None:
        distance = self._dock.clearance(*robot.body) - robot.radius
        touches = self.contact or distance < 1e-9
        if touches and not self._at_dock and driven:
            self.touches.append(Touch(now, speed, self.contact))
        self._at_dock = touches or (self._at_dock and distance < APART)

    def connected(self, now: float, *, flickers: bool, dirty: bool = False) -> bool:
        """Whether current can flow: the contacts bounce at first, flicker forever, or need a second press.

        Args:
            now: Simulated seconds.
            flickers: Whether it never becomes stable.
            dirty: Whether only each second press is one that counts.
        """
        if self._contact_since is None or (dirty and self.presses % 2):
            return False
        since = now - self._contact_since
        if flickers or self._dock.settings.flickers:
            return since % (ON + OFF) < ON
        return since >= self._dock.settings.bounce or self._bouncing.random() < 0.5


class Lip:
    """A lip on the floor in front of the contacts, which the robot gets over when it has pushed for a while."""

    def __init__(self, dock: Dock) -> None:
        """Start with the robot in front of it.

        Args:
            dock: Where it is, and for how long the robot must push.
        """
        self._dock = dock
        self._seconds = dock.settings.lip
        self._pushes_since: float | None = None
        self._over = False

    def hold(self, robot: Robot, now: float, *, driven: bool) -> None:
        """Keep the robot in front of it, or let it over.

        Args:
            robot: Where it has got to.
            now: Simulated seconds.
            driven: Whether it drove there; else it was set down.
        """
        edge = DOCKED.x - LIP
        x, y = robot.body
        if self._seconds == 0.0 or abs(y - self._dock.nearest(y)) > LIP or x <= edge:
            self._over, self._pushes_since = False, None
            return
        if self._over or not driven:
            self._over = True
            return
        self._pushes_since = now if self._pushes_since is None else self._pushes_since
        if now - self._pushes_since < self._seconds:
            robot.block(edge, y, -1.0, 0.0)


def _correct(robot: Robot, solids: Sequence[Solid]) -> None:
    """Move the robot out of all things: being kept out of one may have put it into another."""
    for _ in range(CORRECTIONS):
        within = _find(*robot.body, robot.radius, solids)
        if within is None:
            return
        robot.move_body(within.x, within.y)
    robot.move_body(*next((x, y) for x, y in _around(*robot.body) if _find(x, y, robot.radius, solids) is None))


def _find(x: float, y: float, radius: float, solids: Sequence[Solid]) -> Obstruction | None:
    """The first thing in the way of a robot at this place."""
    found = (solid.obstruct(x, y, radius - ROUNDING) for solid in solids)
    return next((obstruction for obstruction in found if obstruction is not None), None)


def _around(x: float, y: float) -> Iterator[tuple[float, float]]:
    """Places around one, the nearer ones first."""
    for ring in count(1):
        for corner in range(8 * ring):
            angle = math.tau * corner / (8 * ring)
            yield x + RING * ring * math.cos(angle), y + RING * ring * math.sin(angle)
