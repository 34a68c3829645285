"""The last metre: along a smooth curve onto the dock, slowly at the end."""

import math

from docking.behaviors.keep_in_sight import KeepInSight
from docking.behaviors.moves import bounded, steer
from docking.core.errors import DockingError, FailedToControl
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.dock_estimate import Spread
from docking.goal.behavior import Done, Failed, Step
from docking.goal.plan import DockTarget
from docking.parameters import ApproachSettings, MotionLimits
from docking.parameters.limits import braked

PROJECTION = 0.25
"""How far beyond the dock the way leads, in m, as with nav2: the law explodes where its target is."""
SURE = 0.3
"""Standard deviations with which the docked pose is known well enough, as a part of the tolerances."""
LOOK = 0.3
"""Where the robot stands still and looks until it is known so well, in m before the docked pose."""
COMMITTED = 0.06
"""Where it is judged whether the robot comes straight enough, in m before the docked pose."""
GATE = 0.09
"""Where an omnidirectional base must be straight before it drives on, in m before the docked pose."""
FARTHEST_ASIDE, TURNED = 0.15, 0.35
"""The largest errors, in m and rad, that such a base corrects without a retry."""
RESPONSE = 2.0
"""How much of them it corrects, in 1/s."""
GENTLY = 2.0
"""How many times v_linear_min it drives ahead meanwhile, at most."""
HOPELESS = 1.25
"""How many times the tolerances the robot may be off there, as foreseen, before it gives this approach up."""
STRIDE = 0.01
"""Steps, in m, in which the rest of the way is foreseen."""
STALLED = 0.5
"""How long the wheels must have stopped, in s."""
PRESSES = 0.2
"""How long their joints must have stalled, in s: also while the robot speeds up, they turn slowly and hard."""


def sure_enough(settings: ApproachSettings) -> Spread:
    """Return the spread that the docked pose may have before the last piece.

    Args:
        settings: The tolerances there.
    """
    return Spread(SURE * settings.docking_lateral_tolerance, SURE * settings.docking_heading_tolerance)


class Approach:
    """From the staging pose onto the dock.

    Done when the robot cannot get any farther; the battery then shows whether it is docked.
    """

    def __init__(
        self,
        aim: DockTarget,
        motion: MotionLimits,
        settings: ApproachSettings,
        lost: type[DockingError],
        lost_after: float,
        *,
        until: float = -math.inf,
    ) -> None:
        """Begin at about the staging pose, looking at the dock.

        Args:
            aim: The dock.
            motion: Limits of the robot's motion.
            settings: How it drives.
            lost: The error if the dock is out of sight for too long.
            lost_after: How long that is, in s.
            until: How far before the docked pose to stop, in m; the default is at contact.
        """
        self._aim = aim
        self._motion = motion
        self._settings = settings
        self._until = until
        self._sight = KeepInSight(aim, motion, settings, lost, lost_after)
        self._stalled = self._presses = 0.0
        self._looked = 0.0
        self._slid = 0.0
        self._sure = False

    def step(self, observation: Observation, dt: float) -> Step:
        """Drive on, unless something is wrong or there is contact."""
        docked, odometry = self._aim.docked, observation.odometry
        if docked is None or odometry is None:
            return STANDSTILL
        off = odometry.pose.relative_to(docked)
        left = -off.x
        slides = self._can_slide(off, left)
        too_far = slides and left < GATE and not self._is_straight(off, 1.0 if left < COMMITTED else 0.5)
        if left < self._until or (not too_far and self._touches(left, odometry, dt)):
            return Done()
        failure = self._sight.check(left, dt) or (None if slides else self._fault(off, left))
        if failure is not None:
            return Failed(failure)
        held = self._hold(left, dt)
        if held is not None:
            self._stalled = 0.0
            return held
        velocity = self._drive(odometry.pose, docked, left, self._motion.with_braking(observation.braking))
        return self._slide(velocity, off, left, dt, too_far=too_far) if slides else velocity

    def _can_slide(self, off: Pose, left: float) -> bool:
        """Whether the base is omnidirectional, near the dock, and not too far off to correct that sideways."""
        near = self._motion.v_lateral_max > 0.0 and left < LOOK
        return near and abs(off.y) < FARTHEST_ASIDE and abs(off.theta) < TURNED and self._slid < 2.0 * FARTHEST_ASIDE

    def _slide(self, ahead: Velocity, off: Pose, left: float, dt: float, *, too_far: bool) -> Velocity:
        """Correct the lateral error sideways, and the heading; slowly, since nothing sees what is there.

        A robot that is too far off near the dock does not drive on meanwhile, but back where it touches nothing.
        """
        slowest = self._motion.v_linear_min
        sideways = 0.0 if left < COMMITTED else bounded(-RESPONSE * off.y, slowest)
        self._slid += abs(sideways) * dt
        turning = bounded(-RESPONSE * off.theta, self._motion.v_angular_max)
        if not too_far:
            return Velocity(min(ahead.linear_x, GENTLY * slowest) if sideways else ahead.linear_x, turning, sideways)
        self._stalled = 0.0
        return Velocity(-slowest if left < COMMITTED else 0.0, turning, sideways)

    def _hold(self, left: float, dt: float) -> Velocity | None:
        """Return the velocity while the robot must not drive on; None if it may."""
        if self._aim.disputed:
            self._sure = False
        held = self._sight.hold(left)
        if held is None and left < LOOK and not self._sure and not self._is_sure(dt):
            return STANDSTILL
        return held

    def _is_sure(self, dt: float) -> bool:
        """Whether the docked pose is known well enough, or will not be known better."""
        self._looked += dt
        self._sure = self._aim.spread.within(sure_enough(self._settings)) or self._looked > self._settings.look_timeout
        return self._sure

    def _touches(self, left: float, odometry: Odometry, dt: float) -> bool:
        stopped = odometry.velocity.linear_x < 0.25 * self._motion.v_linear_min
        self._stalled = self._stalled + dt if stopped and left < self._settings.docking_threshold else 0.0
        presses = self._aim.stalled and left < self._settings.docking_threshold
        self._presses = self._presses + dt if presses else 0.0
        return left < -self._settings.docking_overshoot or self._stalled > STALLED or self._presses > PRESSES

    def _fault(self, off: Pose, left: float) -> DockingError | None:
        if left < COMMITTED and not self._is_straight(off):
            return FailedToControl(f"the robot is misaligned: {_describe(off)}")
        ahead = self._foresee(off) if COMMITTED <= left < LOOK else Pose()
        if not self._is_straight(ahead, HOPELESS):
            return FailedToControl(
                f"{left:.2f} m before the dock, the robot is too far off to get straight onto it:"
                f" {_describe(off)}. It may have been pushed"
            )
        return None

    def _is_straight(self, off: Pose, times: float = 1.0) -> bool:
        """Whether a pose, relative to the docked pose, is within `times` the tolerances."""
        settings = self._settings
        return (
            abs(off.y) <= times * settings.docking_lateral_tolerance
            and abs(off.theta) <= times * settings.docking_heading_tolerance
        )

    def _foresee(self, off: Pose) -> Pose:
        """Return where the robot will be COMMITTED before the docked pose if it drives on, as seen from that pose."""
        motion, target = self._motion, Pose(PROJECTION)
        most = motion.v_angular_max / motion.v_linear_min
        while off.x < -COMMITTED:
            turn = bounded(steer(off, target, self._settings.gains).curvature, most) * STRIDE
            if abs(off.theta + turn) > 0.5 * math.pi:
                break
            off = off.compose(Pose(STRIDE * math.cos(0.5 * turn), STRIDE * math.sin(0.5 * turn), turn))
        return off

    def _drive(self, robot: Pose, docked: Pose, left: float, motion: MotionLimits) -> Velocity:
        steering = steer(robot, docked.compose(Pose(PROJECTION)), self._settings.gains)
        slowest = motion.v_linear_min
        fast = max(0.0, left - max(self._settings.slowdown_radius, self._until))
        speed = min(motion.v_linear_max / steering.slowness, slowest + braked(fast, motion.a_linear_max))
        speed = max(slowest, speed)
        curvature = steering.curvature - self._aim.yaw_bias
        return Velocity(speed, bounded(curvature * speed, motion.v_angular_max))


def _describe(off: Pose) -> str:
    return f"lateral error {1000 * off.y:.0f} mm, heading error {math.degrees(off.theta):.1f} degrees"
