"""Compares the commanded motion with the motion that odometry measures."""

from collections import deque
from dataclasses import dataclass

from docking.core.errors import Blocked, OdometryLost
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation

DELAY = 0.3
"""How old odometry may be, in s, for the robot to go on driving."""
FARTHEST = 1e6
"""In m from where odometry began; what is farther is no pose."""
PAUSE = 0.4
"""After a longer time without a look, in s, the comparison begins anew: a base stops when commands stay away."""
TOLERANCE = 0.35
"""The fraction of the commanded motion, in both directions, that may be missing: wheels slip."""
LEAST_WAY = 0.04
"""In m; a shorter way missing says nothing: odometry comes late, by up to 0.1 s, and wheels need time to speed up."""
LEAST_TURN = 0.2
"""In rad; a smaller turn missing says nothing."""


_SUMS = ("commanded", "commanded_turn", "to_and_fro", "to_and_fro_turn", "measured", "measured_turn")


@dataclass(frozen=True, slots=True)
class _Ways:
    """Commanded and measured motion between two observations: m forward and rad, since `at`."""

    at: float
    commanded: float
    commanded_turn: float
    measured: float
    measured_turn: float


class MotionWatch:
    """Compares the commanded velocities with odometry.

    Attributes:
        commanded: The velocity since the last look.
    """

    def __init__(self, odometry_timeout: float, blocked_after: float, started_at: float) -> None:
        """Begin at a standstill.

        Args:
            odometry_timeout: Silence of odometry, in s, that is an error.
            blocked_after: Seconds over which commanded and measured motion are compared.
            started_at: Seconds of the monotonic clock.
        """
        self.commanded = STANDSTILL
        self._odometry_timeout = odometry_timeout
        self._blocked_after = blocked_after
        self._heard_at = started_at
        self._last: tuple[float, Pose] | None = None
        self._window: deque[_Ways] = deque()
        self._sums = dict.fromkeys(_SUMS, 0.0)  # of the window

    def rest(self) -> None:
        """Forget earlier motion: the robot was commanded to stand still."""
        self.commanded = STANDSTILL
        self._last = None
        self._window.clear()
        self._sums = dict.fromkeys(_SUMS, 0.0)

    def sees(self, observation: Observation) -> bool:
        """Whether the robot knows where it is, so that it may move.

        Args:
            observation: What is known now; since the last one, `commanded` held.

        Raises:
            OdometryLost: Odometry has been silent for too long.
            Blocked: The robot did not move as commanded.
        """
        now, odometry = observation.now, observation.odometry
        sound = odometry if odometry is not None and _makes_sense(odometry.pose) else None
        if sound is not None:
            self._heard_at = max(self._heard_at, sound.stamp)
        if sound is None or now - sound.stamp > DELAY:
            if now - self._heard_at > self._odometry_timeout:
                nonsense = "" if odometry is sound else f" except an implausible pose, {odometry and odometry.pose}"
                raise OdometryLost(f"no odometry for {self._odometry_timeout:g} s (odometry_timeout){nonsense}")
            return False
        self._remember(now, sound.pose)
        if self._window and now - self._window[0].at >= self._blocked_after:
            self._compare()
        return True

    def _remember(self, now: float, pose: Pose) -> None:
        last, self._last = self._last, (now, pose)
        if last is None:
            return
        dt, moved = now - last[0], pose.relative_to(last[1])
        if not 0.0 <= dt <= PAUSE:  # nobody knows for how long the command held
            self.rest()
            return
        ways = _Ways(last[0], self.commanded.linear_x * dt, self.commanded.angular_z * dt, moved.x, moved.theta)
        self._window.append(ways)
        self._add(ways, 1.0)
        while len(self._window) > 1 and now - self._window[1].at >= self._blocked_after:
            self._add(self._window.popleft(), -1.0)

    def _add(self, ways: _Ways, sign: float) -> None:
        sums = self._sums
        sums["commanded"] += sign * ways.commanded
        sums["commanded_turn"] += sign * ways.commanded_turn
        sums["to_and_fro"] += sign * abs(ways.commanded)
        sums["to_and_fro_turn"] += sign * abs(ways.commanded_turn)
        sums["measured"] += sign * ways.measured
        sums["measured_turn"] += sign * ways.measured_turn

    def _compare(self) -> None:
        sums = self._sums
        missing, missing_turn = (
            abs(sums["commanded"] - sums["measured"]),
            abs(sums["commanded_turn"] - sums["measured_turn"]),
        )
        if missing > max(LEAST_WAY, TOLERANCE * sums["to_and_fro"]) or missing_turn > max(
            LEAST_TURN, TOLERANCE * sums["to_and_fro_turn"]
        ):
            raise Blocked(
                f"commanded {sums['commanded']:.2f} m and {sums['commanded_turn']:.2f} rad within"
                f" {self._blocked_after:g} s (blocked_after), measured"
                f" {sums['measured']:.2f} m and {sums['measured_turn']:.2f} rad"
            )


def _makes_sense(pose: Pose) -> bool:
    return pose.finite and max(abs(pose.x), abs(pose.y), abs(pose.theta)) < FARTHEST
