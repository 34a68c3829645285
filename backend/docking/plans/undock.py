"""An undocking goal from its acceptance to its end."""

from docking.behaviors.back_out import BackOut
from docking.core.battery import BatteryReading
from docking.core.errors import Blocked, DockingError, ErrorCode, FailedToUndock, Stage
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.goal.engine import Command, Goal, Outcome
from docking.goal.limiter import Limiter
from docking.goal.motion_watch import MotionWatch
from docking.parameters import MotionLimits, UndockTimeouts


class UndockGoal(Goal):
    """A goal to undock: the robot backs out until it is as far away as its staging pose, and charges no longer.

    One whose battery is not connected to a charger in the first place is not docked, and succeeds at once.
    """

    def __init__(self, distance: float, motion: MotionLimits, timeouts: UndockTimeouts, started_at: float) -> None:
        """Start the goal.

        Args:
            distance: How far to back out, in m.
            motion: What the robot may do.
            timeouts: Its time limits.
            started_at: Seconds of the monotonic clock.
        """
        super().__init__(timeouts, started_at)
        self._undocking_timeout = timeouts.undocking_timeout
        self._controller = BackOut(distance, motion)
        self._limiter = Limiter(motion)
        self._watch = MotionWatch(timeouts.odometry_timeout, timeouts.blocked_after, started_at)
        self._time = 0.0
        self._docked = False  # as far as is known
        self._out = False

    def _is_reached(self, battery: BatteryReading) -> bool:
        return not battery.connected and (self._out or not self._docked)

    def _go_on(self, observation: Observation, dt: float) -> Command | Outcome:
        self._docked = True
        self._time += dt
        try:
            if not self._watch.sees(observation):
                return Command(Stage.UNDOCKING, self._rest())
            velocity = self._move(observation, dt)
        except Blocked as failure:
            return self.abort(ErrorCode.FAILED_TO_UNDOCK, f"the robot did not get away from the dock: {failure}")
        except DockingError as failure:
            return self.abort(failure.error_code, str(failure))
        self._watch.commanded = velocity
        return Command(Stage.UNDOCKING, velocity)

    def _move(self, observation: Observation, dt: float) -> Velocity:
        """Back out, then stand still.

        Raises:
            FailedToUndock: It has taken too long.
        """
        if self._time > self._undocking_timeout:
            what = "the battery is still charging" if self._out else "the robot did not get away from the dock"
            raise FailedToUndock(f"{what} after {self._undocking_timeout:g} s (undocking_timeout)")
        step = STANDSTILL if self._out else self._controller.step(self._watch.ahead(observation), dt)
        if isinstance(step, Done):
            self._out = True
            return self._rest()
        return self._limiter.limit(step, dt, self._watch.model.dead_zone)

    def _rest(self) -> Velocity:
        self._watch.rest()
        return self._limiter.stop()
