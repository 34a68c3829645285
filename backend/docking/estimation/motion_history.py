"""The motion of the last seconds, as commanded and as odometry measured it."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity

PAUSE = 0.4
"""In s; after a longer time without a pose, the motion is unknown: a base stops when commands stay away."""
WINDOW = 0.15
"""Seconds over which a velocity is measured."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Ways from the start on.

    Attributes:
        way: Forward, in m.
        turn: To the left, in rad.
        to_and_fro: Forward and backward, in m.
        turn_to_and_fro: To the left and to the right, in rad.
    """

    way: float = 0.0
    turn: float = 0.0
    to_and_fro: float = 0.0
    turn_to_and_fro: float = 0.0

    def plus(self, way: float, turn: float) -> "Motion":
        """The motion with one more step."""
        return Motion(self.way + way, self.turn + turn, self.to_and_fro + abs(way), self.turn_to_and_fro + abs(turn))

    def then(self, after: "Motion") -> "Motion":
        """The motion with another one behind it."""
        return Motion(
            self.way + after.way,
            self.turn + after.turn,
            self.to_and_fro + after.to_and_fro,
            self.turn_to_and_fro + after.turn_to_and_fro,
        )

    def since(self, before: "Motion") -> "Motion":
        """The motion from `before` to now."""
        return Motion(
            self.way - before.way,
            self.turn - before.turn,
            self.to_and_fro - before.to_and_fro,
            self.turn_to_and_fro - before.turn_to_and_fro,
        )

    def towards(self, after: "Motion", share: float) -> "Motion":
        """The motion at a share of the way to `after`: a linear interpolation."""
        return Motion(
            self.way + share * (after.way - self.way),
            self.turn + share * (after.turn - self.turn),
            self.to_and_fro + share * (after.to_and_fro - self.to_and_fro),
            self.turn_to_and_fro + share * (after.turn_to_and_fro - self.turn_to_and_fro),
        )


NOWHERE = Motion()


class MotionHistory:
    """Commanded and measured motion, by time.

    Attributes:
        last: The last pose by odometry, in odom; None before the first.
        changed_at: When odometry last had another pose, in s.
        known_since: Since when there was no pause, in s.
        coming: What was commanded since the last step of `add`.
    """

    def __init__(self, memory: float) -> None:
        """Know nothing.

        Args:
            memory: Seconds that are kept at least.
        """
        self.last: Pose | None = None
        self.changed_at = -math.inf
        self.known_since = math.inf
        self.coming = NOWHERE
        self._commanded_until = -math.inf
        self._memory = memory
        self._times: list[float] = []
        self._commanded: list[Motion] = []
        self._measured: list[Motion] = []

    def command(self, now: float, commanded: Velocity) -> None:
        """Count a velocity that was commanded until now, also where odometry is silent.

        Args:
            now: The moment, in s.
            commanded: The velocity since the last call.
        """
        dt = now - self._commanded_until
        self._commanded_until = now
        if 0.0 < dt < math.inf:
            self.coming = self.coming.plus(commanded.linear_x * dt, commanded.angular_z * dt)

    def add(self, now: float, pose: Pose, commanded: Velocity) -> bool:
        """Add a step; return whether there is one: after a pause, the history begins here.

        Args:
            now: The moment, in s. A moment that is not later than the last one is ignored.
            pose: By odometry, in odom.
            commanded: The velocity since the last step, or the last call of `command`.
        """
        self.command(now, commanded)
        coming, self.coming = self.coming, NOWHERE
        last, self.last = self.last, pose
        if pose != last:
            self.changed_at = now
        dt = now - self._times[-1] if self._times else math.inf
        if last is None or dt > PAUSE:
            self._times, self._commanded, self._measured = [now], [NOWHERE], [NOWHERE]
            self.known_since = now
            return False
        if dt <= 0.0:
            return False
        moved = pose.relative_to(last)
        self._times.append(now)
        self._commanded.append(self._commanded[-1].then(coming))
        self._measured.append(self._measured[-1].plus(moved.x, moved.theta))
        if self._times[0] < now - 2.0 * self._memory:
            gone = bisect_right(self._times, now - self._memory)
            del self._times[:gone], self._commanded[:gone], self._measured[:gone]
        return True

    @property
    def now(self) -> float:
        """The moment of the last step, in s; -inf before the first."""
        return self._times[-1] if self._times else -math.inf

    def commands(self, begin: float, end: float) -> Motion:
        """The motion that was commanded between two moments."""
        return self._at(self._commanded, end).since(self._at(self._commanded, begin))

    def measured(self, begin: float, end: float) -> Motion:
        """The motion that odometry measured between two moments."""
        return self._at(self._measured, end).since(self._at(self._measured, begin))

    def last_step(self) -> tuple[float, Motion, Motion]:
        """Return when the last step began, in s, and its motion, commanded and measured. There must be one."""
        began, now = self._times[-2:]
        return began, self.commands(began, now), self.measured(began, now)

    def _at(self, history: list[Motion], at: float) -> Motion:
        times = self._times
        index = bisect_right(times, at)
        if index == 0:
            return history[0] if history else NOWHERE
        if index == len(times):
            return history[-1]
        before, after = times[index - 1], times[index]
        return history[index - 1].towards(history[index], (at - before) / (after - before))

    @property
    def velocity(self) -> Velocity:
        """The measured velocity: from poses, since not every odometry has a velocity."""
        if len(self._times) < 2:
            return STANDSTILL
        now = self._times[-1]
        seconds = min(WINDOW, now - self._times[0])
        moved = self.measured(now - seconds, now)
        return Velocity(moved.way / seconds, moved.turn / seconds)

    def velocity_at(self, moment: float) -> Velocity:
        """The velocity at a moment, measured over `WINDOW` before it."""
        if not self._times:
            return STANDSTILL
        moved = self.measured(moment - WINDOW, moment)
        return Velocity(moved.way / WINDOW, moved.turn / WINDOW)
