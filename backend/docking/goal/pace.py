"""Limits the speed: slow near the dock, where the robot is not seen to move, and backwards without a view."""

import math

from docking.core.errors import FailedToControl
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.estimation.motion_model import AT_REST, MotionModel
from docking.goal.hits import Hits
from docking.goal.plan import KnownPoses
from docking.goal.recent_poses import RecentPoses
from docking.parameters import MotionLimits
from docking.parameters.limits import RESERVE, braked

SIDE = 0.3
"""How far to either side of the docked pose the dock may reach, in m."""
NEAR = 0.2
"""How near to the dock, in m, a robot that stands may stand against it."""
AT_DOCK = 0.02
"""How much faster than v_linear_min, in m/s, a base with a dead zone may touch its dock."""
GENTLE = 0.15
"""How fast the robot slows down on the way to the dock, in m/s²."""
CAUTIOUS = 0.08
"""The same of a base that was not seen to slow down by `SHOWN`."""
SHOWN = 0.2
"""In m/s²."""
OF_LIMIT = 0.8
"""The part of its highest deceleration that a weak base slows down with there."""
ROUNDING = 1e-6
LONGEST_STEP = 0.2
"""In s; after a longer pause the robot does not change its velocity by more than in this time."""
PULSE = 0.2
"""How long the base turns at its slowest, in s, where it is to turn slower than that."""


class Pace:
    """Limits what a controller asks for to what the robot may do next.

    - Near the dock nothing raises the speed above `v_linear_min`, or above the lowest at which the base moves. No dead
      zone is learned there: a base that stands may stand against the dock.
    - A base that is known to move only at more than `v_linear_min` and `AT_DOCK` stops before its dock.
    - So the robot starts slowly, once the dock is known, until it is seen to move: that tells the dead zone.
    - It stays slow until the marker was seen to move as the robot drives. That may end: so it slows down before the
      nearest place where the dock was believed to be a moment ago.
    - A robot that stands although it is to drive is blocked, or odometry says so wrongly: it drives slowly, too.
    - Backwards it is not faster than `v_linear_back`, whatever moves it, unless a scan shows that the way is free.
    """

    def __init__(self, limits: MotionLimits, slowdown_radius: float, hits: Hits | None = None) -> None:
        """Start at a standstill.

        Args:
            limits: Limits of the robot's motion.
            slowdown_radius: The last part of the way to the docked pose, in m, that is driven slowly.
            hits: Where the robot has run into something: it comes there slowly, too.
        """
        self._limits = limits
        self._hits = hits or Hits()
        self._limiter = Limiter(limits)
        self._radius = slowdown_radius
        self._stands = True
        self._beginning = False
        self._recent = RecentPoses()

    def next(
        self,
        desired: Velocity,
        dt: float,
        robot: Pose,
        poses: KnownPoses,
        model: MotionModel,
        *,
        sees_behind: bool = False,
        slowly: bool = False,
    ) -> Velocity:
        """Return the next velocity on the way to a desired one. If the robot cannot slow down in time, it stops.

        Args:
            desired: The velocity that the controller asks for.
            dt: Seconds since the last velocity.
            robot: base_link by the last odometry, in odom.
            poses: Poses of the dock.
            model: How the base carries out commands.
            sees_behind: Whether a scan shows what is behind the robot.
            slowly: Whether the robot may be somewhere else than it is taken to be, and must drive at its slowest.

        Raises:
            FailedToControl: The base cannot drive slowly enough to touch the dock.
        """
        if slowly or (desired.linear_x < 0.0 and not sees_behind):
            most = self._limits.v_linear_min if slowly else self._limits.v_linear_back
            desired = _slowed(desired, max(most, model.dead_zone.linear_x))
        coming = model.unseen.way
        left = self._distance(robot, poses, coming, desired.linear_x)
        most_at_dock = self._limits.v_linear_min + AT_DOCK
        model.learns, model.tried_first = left > NEAR, most_at_dock
        if left <= NEAR and model.sure_zone > most_at_dock + ROUNDING:
            raise FailedToControl(
                f"the base moves at {model.sure_zone:.2f} m/s, not at less, and may touch the dock at"
                f" {most_at_dock:.2f} m/s at most: set v_linear_min (now {self._limits.v_linear_min:g}) to the lowest"
                " speed at which it moves, if it and the dock bear that"
            )
        self._recent.add(robot, poses)
        unproven = poses.filtered_dock is not None and not poses.proven
        begins = self._begins(desired, poses, model) or unproven
        slowest, sure = (max(self._limits.v_linear_min, zone) for zone in (model.dead_zone.linear_x, model.sure_zone))
        first = slowest if begins or model.stands else math.inf
        gentle = _gentle(model)

        def most_at(linear: float) -> float:
            """The highest speed, in m/s, on a way that begins with this velocity."""
            nearest = min((self._distance(robot, one, coming, linear) for one in self._recent), default=math.inf)
            dock = max(0.0, nearest - poses.late * abs(model.history.velocity.linear_x))  # however late it is seen
            hit = self._hits.distance(robot, coming, linear)
            return min(first, self._near_dock(dock, sure, gentle), self._near_dock(hit + self._radius, slowest, gentle))

        velocity = self._limiter.limit(_slowed(desired, most_at(desired.linear_x)), dt, model.dead_zone)
        if abs(velocity.linear_x) > most_at(velocity.linear_x) + ROUNDING:
            return self.stop()
        self._stands = velocity.linear_x == 0.0
        return velocity

    def stop(self) -> Velocity:
        """Stand still at once: a stop is never delayed."""
        self._stands = True
        return self._limiter.stop()

    def _begins(self, desired: Velocity, poses: KnownPoses, model: MotionModel) -> bool:
        """Whether the robot begins to drive, and it is not known whether it does so at its slowest.

        Each start finds out again, away from the dock: the base may have stood before since it was held.
        """
        if desired.linear_x == 0.0 or poses.filtered_dock is None:
            self._beginning = False
        elif self._stands and abs(model.history.velocity.linear_x) < AT_REST and not self._beginning:
            self._beginning = model.moves_at > self._limits.v_linear_min + ROUNDING
            if self._beginning and model.learns:
                model.relearn()
        elif model.moves_at < math.inf:
            self._beginning = False
        return self._beginning

    def _near_dock(self, left: float, slowest: float, gentle: float) -> float:
        """The highest speed, in m/s, where the dock may be so near, in m, and the robot slows down by so much."""
        way = max(0.0, left - self._radius)
        return math.hypot(slowest, braked(way, min(gentle / RESERVE, self._limits.a_linear_max)))

    def _distance(self, robot: Pose, poses: KnownPoses, coming: float, linear: float) -> float:
        """Return how near to the dock the robot may be on its way there, in m; infinite where it is on no such way.

        Args:
            robot: By the last odometry.
            poses: Poses of the dock.
            coming: The way, in m, that was commanded since then and may have been driven.
            linear: The velocity forward, in m/s.
        """
        docked, staging = poses.filtered_dock, poses.staging
        if docked is None or staging is None or linear == 0.0:
            return math.inf
        axis = math.atan2(docked.y - staging.y, docked.x - staging.x)
        if linear * math.cos(robot.theta - axis) <= 0.0:
            return math.inf
        off = robot.relative_to(Pose(docked.x, docked.y, axis))
        left = max(0.0, -off.x - poses.uncertainty - max(0.0, math.copysign(coming, coming * linear)))
        return math.hypot(left, max(0.0, abs(off.y) - SIDE))


def _gentle(model: MotionModel) -> float:
    """Return how fast the base can slow down for sure, in m/s²."""
    braking = model.braking
    if braking.limit < math.inf:
        return min(GENTLE, OF_LIMIT * braking.limit)
    return GENTLE if braking.shown >= SHOWN else CAUTIOUS


def _slowed(velocity: Velocity, most: float) -> Velocity:
    """The velocity on the same arc that is not faster."""
    if abs(velocity.linear_x) <= most:
        return velocity
    return velocity.times(most / abs(velocity.linear_x))


class Limiter:
    """Limits a desired velocity to what the robot may do next, starting from the previous command."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._last = STANDSTILL
        self._owed = 0.0  # rad that were to be turned, and too slowly for the base
        self._pulsing = False

    def limit(self, desired: Velocity, dt: float, dead_zone: Velocity = STANDSTILL) -> Velocity:
        """Return the velocity closest to the desired one that keeps all limits.

        If the base cannot turn as slowly as desired, it turns in pulses, so that the mean is right.

        Args:
            desired: The velocity that the controller asks for.
            dt: Seconds since the last velocity.
            dead_zone: Learned dead zone: smaller velocities do not move the base.
        """
        limits, dt = self.limits, min(dt, LONGEST_STEP)
        slowest = max(limits.v_linear_min, dead_zone.linear_x)
        linear = desired.linear_x
        angular = self._pulse(desired.angular_z, max(limits.v_angular_min, dead_zone.angular_z), dt)
        if 0.0 < abs(linear) < slowest:
            linear = math.copysign(slowest, linear)
        self._last = Velocity(
            _towards(self._last.linear_x, linear, limits.v_linear_max, limits.a_linear_max * dt),
            _towards(self._last.angular_z, angular, limits.v_angular_max, limits.a_angular_max * dt),
            _towards(self._last.linear_y, desired.linear_y, limits.v_lateral_max, limits.a_linear_max * dt),
        )
        return self._last

    def _pulse(self, desired: float, slowest: float, dt: float) -> float:
        if abs(desired) >= slowest:
            self._owed, self._pulsing = 0.0, False
            return desired
        self._owed += desired * dt
        if not self._pulsing:
            self._pulsing = abs(self._owed) >= PULSE * slowest
            return 0.0
        sign = math.copysign(1.0, self._owed)
        self._owed -= sign * slowest * dt
        self._pulsing = self._owed * sign > 0.0
        return sign * slowest

    def stop(self) -> Velocity:
        """Stand still at once: a stop is never delayed."""
        self._last = STANDSTILL
        self._owed, self._pulsing = 0.0, False
        return STANDSTILL


def _towards(last: float, desired: float, most: float, change: float) -> float:
    lowest, highest = max(-most, last - change), min(most, last + change)
    return min(max(desired, lowest), highest)
