"""Compares the commanded motion with the motion that odometry measures."""

import math
from dataclasses import replace

from docking.core.errors import Blocked, OdometryJumped, OdometryLost
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.motion_model import MotionModel

DELAY = 0.3
"""How old odometry may be, in s, for the robot to go on driving."""
REPORTED_AFTER = 1.0
"""Seconds without odometry after which a goal says that it waits: discovery or a busy processor takes a moment."""
FARTHEST = 1e6
"""In m from where odometry began; a pose farther away is implausible."""
LAGS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
"""Lags, in s, with which the base may carry out a command: messages take time, and wheels speed up slowly."""
LEAST_MOTION = 0.3
"""Least share of the commanded motion: many bases drive slower than commanded, and wheels slip."""
MOST_MOTION = 1.35
"""Largest multiple of the commanded motion, forward and backward."""
WEAKEST = 0.05
"""In m/s²; a base whose velocity changes more slowly towards the command is blocked."""
LEAST_WAY = 0.04
"""In m; a shorter way missing, or too much, says nothing."""
LEAST_TURN = 0.2
"""In rad; a smaller turn missing, or too much, says nothing."""
REPEATED = 0.1
"""Seconds after which a pose that is the same again is repeated, where the robot moves."""
UNSEEN = Velocity(0.01, 0.05)
"""Least motion that must have been commanded in that time, in m and rad."""
MOVING = Velocity(0.05, 0.1)
"""In m/s and rad/s: by its velocity, odometry moves, and faster than it may stall at the dock."""
DOUBTED_FOR = 0.6
"""Seconds for which a pose is doubted that is the same again, where odometry has no velocities."""
JUMP = (0.05, 0.25)
"""In m and rad; odometry that gets farther at once than commanded, by more, has jumped."""
CARRIED = (0.5, 1.0)
"""In m/s and rad/s; how fast someone may move the robot in that time."""
CARRIED_FOR = 0.5
"""Seconds for which that is believed after a silence: a pose farther away is of a base that has restarted."""


class MotionWatch:
    """Compares the commanded velocities with odometry.

    Attributes:
        model: How the base carries out commands.
        waiting: Why the robot waits for odometry, as a sentence; empty while odometry comes, or is only a little late.
    """

    def __init__(self, odometry_timeout: float, blocked_after: float, started_at: float) -> None:
        """Start at a standstill.

        Args:
            odometry_timeout: Silence of odometry, in s, after which the goal is given up.
            blocked_after: Seconds over which commanded and measured motion are compared.
            started_at: Seconds of the monotonic clock.
        """
        self.model = MotionModel(blocked_after)
        self.waiting = ""
        self._odometry_timeout = odometry_timeout
        self._blocked_after = blocked_after
        self._heard_at = started_at
        self._silent = False  # at the last step
        self._first: Odometry | None = None  # of those with the same pose as the last
        self._repeats = self._has_velocity = False
        self._begins_at = self._looked_at = started_at

    @property
    def commanded(self) -> Velocity:
        """The velocity since the last step."""
        return self.model.commanded

    @commanded.setter
    def commanded(self, velocity: Velocity) -> None:
        self.model.commanded = velocity

    def elapse(self, now: float) -> None:
        """Let time pass, in which `commanded` applied: call it before another velocity is commanded."""
        self.model.elapse(now)

    def rest(self) -> None:
        """The robot is commanded to stand still."""
        self.model.commanded = STANDSTILL

    def restart(self) -> None:
        """Begin a new comparison: what came before was reported, or meant, such as pushing against the dock."""
        self._begins_at = self._looked_at

    def sees(self, observation: Observation) -> bool:
        """Whether the robot knows where it is, so that it may move.

        Args:
            observation: Current sensor readings. `commanded` applied since the previous ones.

        Raises:
            OdometryLost: Odometry has been silent for too long.
            Blocked: The robot did not move as commanded; `OdometryJumped`: no robot moves so.
        """
        sound = self.hears(observation)
        if sound is None:
            self._silent = True
            return False
        since, now = observation.now - self._looked_at, observation.now
        if self._silent:
            since, self._silent = min(since, CARRIED_FOR), False
        self._looked_at = now
        jump = self._jump(now, since, sound.pose)
        self.model.update(now, sound.pose)
        if jump:
            self.restart()
            raise OdometryJumped(jump)
        self._compare(now)
        return True

    def hears(self, observation: Observation) -> Odometry | None:
        """The odometry, also while nav2 drives; None while it is late, so that the robot must not move.

        Args:
            observation: Current sensor readings.

        Raises:
            OdometryLost: Odometry has been silent for too long.
        """
        now, odometry = observation.now, observation.odometry
        sound = odometry if odometry is not None and makes_sense(odometry.pose) else None
        repeats = sound is not None and self._is_repeated(sound, now)
        if sound is not None and not repeats:
            self._heard_at = max(self._heard_at, sound.stamp)
        if sound is not None and not repeats and now - sound.stamp <= DELAY:
            self.waiting = ""
            return sound
        nonsense = "" if odometry is sound else f" except an implausible pose, {odometry and odometry.pose}"
        if repeats:
            nonsense = " except one pose, again and again, although its velocity says that the robot moves"
        silence = now - self._heard_at
        if silence > self._odometry_timeout:
            raise OdometryLost(f"no odometry for {self._odometry_timeout:g} s (odometry_timeout){nonsense}")
        if silence > REPORTED_AFTER:
            self.waiting = f"no odometry for over {REPORTED_AFTER:g} s{nonsense}: the robot waits"
        return None

    def _is_repeated(self, odometry: Odometry, now: float) -> bool:
        """Whether odometry repeats a pose while the robot moves, until there is another pose.

        A robot that is blocked has one pose, too, but its velocity is 0, or it has never moved. Of odometry that has no
        velocities nothing tells the two apart: it is doubted for a moment, and the robot is slow until it moves.
        """
        self._has_velocity |= odometry.velocity != STANDSTILL
        first = self._first
        if first is None or odometry.pose != first.pose:
            self._first, self._repeats = odometry, False
            return False
        age = odometry.stamp - first.stamp
        if not self._has_velocity and age > DOUBTED_FOR:
            return False
        if not self._repeats and age > REPEATED:
            reported, before = odometry.velocity, self.model.history.velocity_at(first.stamp)
            unseen = self.model.expected(first.stamp, now)
            self._repeats = (
                (not self._has_velocity or abs(reported.linear_x) > MOVING.linear_x)
                and abs(before.linear_x) > MOVING.linear_x
                and unseen.to_and_fro > UNSEEN.linear_x
            ) or (
                (not self._has_velocity or abs(reported.angular_z) > MOVING.angular_z)
                and abs(before.angular_z) > MOVING.angular_z
                and unseen.turn_to_and_fro > UNSEEN.angular_z
            )
        return self._repeats

    def _jump(self, now: float, since: float, pose: Pose) -> str:
        """Describe a jump of odometry that no robot can make; empty without one.

        Args:
            now: The moment.
            since: Seconds since the last step.
            pose: The pose by odometry.
        """
        last = self.model.history.last
        if last is None:
            return ""
        moved, may = pose.relative_to(last), self.model.possible(now)
        forward, backward = 0.5 * (may.to_and_fro + may.way), 0.5 * (may.to_and_fro - may.way)
        slack, slack_turn = JUMP[0] + CARRIED[0] * since, JUMP[1] + CARRIED[1] * since
        turn = MOST_MOTION * may.turn_to_and_fro + slack_turn
        way = MOST_MOTION * (forward if moved.x > 0.0 else backward) + slack
        if abs(moved.x) <= way and abs(moved.y) <= slack + abs(moved.x) and abs(moved.theta) <= turn:
            return ""
        return (
            f"odometry jumped: {math.hypot(moved.x, moved.y):.2f} m and {abs(moved.theta):.2f} rad within"
            f" {since:.2g} s, from {last} to {pose}"
        )

    def ahead(self, observation: Observation) -> Observation:
        """Return the observation of the moment when a command that is given now takes effect, with the robot there.

        It says how fast the base slows down, too.
        """
        odometry = observation.odometry
        if odometry is None:
            return observation
        there = replace(odometry, pose=self.model.ahead(odometry.pose), velocity=self.model.history.velocity)
        return replace(observation, odometry=there, braking=self.model.deceleration)

    def _compare(self, now: float) -> None:
        begin = now - self._blocked_after
        if begin < max(self._begins_at, self.model.history.known_since):
            return
        history = self.model.history
        measured = history.measured(begin, now)
        speeds_up, rolled_on = self._speeds_up(begin, now), self._has_rolled_on(begin, now)
        for lag in LAGS:
            commanded = history.commands(begin - lag, now - lag)
            to_and_fro = math.inf if rolled_on else commanded.to_and_fro
            drives = speeds_up or _fits(commanded.way, to_and_fro, measured.way, LEAST_WAY)
            if drives and _fits(commanded.turn, commanded.turn_to_and_fro, measured.turn, LEAST_TURN):
                return
        commanded = history.commands(begin, now)
        still = self._first is not None and self._first.stamp <= begin
        tried = self.model.dead_zone.linear_x
        slow = (
            f". If nothing holds it, its base may need {tried:.2f} m/s or more: set v_linear_min to the lowest speed at"
            " which it moves"
            if tried > self.model.sure_zone
            else ""
        )
        self.restart()
        self.model.forget_stand()
        raise Blocked(
            f"motion does not match command: commanded {commanded.way:.2f} m and {commanded.turn:.2f} rad within"
            f" {self._blocked_after:g} s (blocked_after), measured {measured.way:.2f} m and {measured.turn:.2f} rad"
            f"{': the robot is blocked, or its odometry repeats one pose' if still else ''}{slow}"
        )

    def _speeds_up(self, begin: float, now: float) -> bool:
        """Whether the base is still on its way to the commanded velocity, as a weak one that reverses."""
        half = 0.5 * (now - begin)
        before, after = self._halves(begin, now)
        wanted, change = self.model.history.commands(begin + half, now).way - before, after - before
        return wanted * change > 0.0 and abs(change) > WEAKEST * half**2

    def _has_rolled_on(self, begin: float, now: float) -> bool:
        """Whether a weak base came too far since it took long to slow down, and comes no farther than commanded now."""
        before, after = self._halves(begin, now)
        commanded = self.model.history.commands(begin + 0.5 * (now - begin) - LAGS[-1], now)
        return abs(after) < abs(before) and abs(after) <= MOST_MOTION * commanded.to_and_fro + 0.5 * LEAST_WAY

    def _halves(self, begin: float, now: float) -> tuple[float, float]:
        """The measured way in the first and in the second half of a time, in m."""
        history, middle = self.model.history, begin + 0.5 * (now - begin)
        return history.measured(begin, middle).way, history.measured(middle, now).way


def _fits(commanded: float, to_and_fro: float, measured: float, least: float) -> bool:
    """Whether one of the two, way or turn, was carried out."""
    if commanded < 0.0 or commanded == 0.0 > measured:
        commanded, measured = -commanded, -measured
    missing, more = LEAST_MOTION * commanded - measured, measured - MOST_MOTION * to_and_fro
    return (missing <= 0.0 or commanded - measured <= least) and more <= least


def makes_sense(pose: Pose) -> bool:
    """Whether a robot can be there."""
    return pose.finite and max(abs(pose.x), abs(pose.y), abs(pose.theta)) < FARTHEST
