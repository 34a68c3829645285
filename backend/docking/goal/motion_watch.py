"""Compares the commanded motion with the motion that odometry measures."""

from dataclasses import replace

from docking.core.errors import Blocked, OdometryLost
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.motion_model import MotionModel

DELAY = 0.3
"""How old odometry may be, in s, for the robot to go on driving."""
FARTHEST = 1e6
"""In m from where odometry began; what is farther is no pose."""
LAGS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
"""How late, in s, the base may do what it is told: commands and odometry take time, and wheels speed up slowly."""
LEAST_MOTION = 0.3
"""The part of the commanded motion that there must be: many bases drive slower than they are told, and wheels slip."""
MOST_MOTION = 1.35
"""How many times the commanded motion, forward and backward, there may be."""
WEAKEST = 0.1
"""In m/s²; a base whose velocity changes more slowly towards the command is blocked."""
LEAST_WAY = 0.04
"""In m; a shorter way missing, or too much, says nothing."""
LEAST_TURN = 0.2
"""In rad; a smaller turn missing, or too much, says nothing."""


class MotionWatch:
    """Compares the commanded velocities with odometry.

    Attributes:
        model: How the base carries out commands.
    """

    def __init__(self, odometry_timeout: float, blocked_after: float, started_at: float) -> None:
        """Begin at a standstill.

        Args:
            odometry_timeout: Silence of odometry, in s, that is an error.
            blocked_after: Seconds over which commanded and measured motion are compared.
            started_at: Seconds of the monotonic clock.
        """
        self.model = MotionModel(blocked_after)
        self._odometry_timeout = odometry_timeout
        self._blocked_after = blocked_after
        self._heard_at = started_at
        self._begins_at = self._looked_at = started_at

    @property
    def commanded(self) -> Velocity:
        """The velocity since the last look."""
        return self.model.commanded

    @commanded.setter
    def commanded(self, velocity: Velocity) -> None:
        self.model.commanded = velocity

    def rest(self) -> None:
        """The robot is commanded to stand still."""
        self.model.commanded = STANDSTILL

    def restart(self) -> None:
        """Begin a new comparison: what came before was reported, or meant, such as pushing against the dock."""
        self._begins_at = self._looked_at

    def sees(self, observation: Observation) -> bool:
        """Whether the robot knows where it is, so that it may move.

        Args:
            observation: What is known now; since the last one, `commanded` held.

        Raises:
            OdometryLost: Odometry has been silent for too long.
            Blocked: The robot did not move as commanded.
        """
        sound = self.hears(observation)
        if sound is None:
            return False
        now = self._looked_at = observation.now
        self.model.look(now, sound.pose)
        self._compare(now)
        return True

    def hears(self, observation: Observation) -> Odometry | None:
        """The odometry, also while nav2 drives; None while it is late.

        Args:
            observation: What is known now.

        Raises:
            OdometryLost: Odometry has been silent for too long.
        """
        now, odometry = observation.now, observation.odometry
        sound = odometry if odometry is not None and makes_sense(odometry.pose) else None
        if sound is not None:
            self._heard_at = max(self._heard_at, sound.stamp)
        if sound is None or now - sound.stamp > DELAY:
            if now - self._heard_at > self._odometry_timeout:
                nonsense = "" if odometry is sound else f" except an implausible pose, {odometry and odometry.pose}"
                raise OdometryLost(f"no odometry for {self._odometry_timeout:g} s (odometry_timeout){nonsense}")
            return None
        return sound

    def ahead(self, observation: Observation) -> Observation:
        """The same when a command that is given now takes effect: the robot is where it will be then."""
        odometry = observation.odometry
        if odometry is None:
            return observation
        return replace(
            observation, odometry=replace(odometry, pose=self.model.ahead(odometry.pose), velocity=self.model.velocity)
        )

    def _compare(self, now: float) -> None:
        begin = now - self._blocked_after
        if begin < max(self._begins_at, self.model.known_since):
            return
        measured = self.model.measured(begin, now)
        speeds_up = self._speeds_up(begin, now)
        for lag in LAGS:
            commanded = self.model.commands(begin - lag, now - lag)
            drives = speeds_up or _fits(commanded.way, commanded.to_and_fro, measured.way, LEAST_WAY)
            if drives and _fits(commanded.turn, commanded.turn_to_and_fro, measured.turn, LEAST_TURN):
                return
        commanded = self.model.commands(begin, now)
        self.restart()
        raise Blocked(
            f"motion does not match command: commanded {commanded.way:.2f} m and {commanded.turn:.2f} rad within"
            f" {self._blocked_after:g} s (blocked_after), measured {measured.way:.2f} m and {measured.turn:.2f} rad"
        )

    def _speeds_up(self, begin: float, now: float) -> bool:
        """Whether the base is still on its way to the commanded velocity, as a weak one that reverses."""
        half = 0.5 * (now - begin)
        before, after = self.model.measured(begin, begin + half).way, self.model.measured(begin + half, now).way
        wanted, change = self.model.commands(begin + half, now).way - before, after - before
        return wanted * change > 0.0 and abs(change) > WEAKEST * half**2


def _fits(commanded: float, to_and_fro: float, measured: float, least: float) -> bool:
    """Whether one of the two, way or turn, was carried out."""
    if commanded < 0.0:
        commanded, measured = -commanded, -measured
    missing, more = LEAST_MOTION * commanded - measured, measured - MOST_MOTION * to_and_fro
    return (missing <= 0.0 or commanded - measured <= least) and more <= least


def makes_sense(pose: Pose) -> bool:
    """Whether a robot can be there."""
    return pose.finite and max(abs(pose.x), abs(pose.y), abs(pose.theta)) < FARTHEST
