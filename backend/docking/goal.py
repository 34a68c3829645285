"""A docking goal from its acceptance to its end: a state machine that is given the time and the battery."""

import enum
from dataclasses import dataclass

from docking.battery import BatteryReading
from docking.controllers.protocol import Controller, Done, Failed
from docking.failures import ErrorCode, Stage
from docking.observation import STANDSTILL, Observation, Velocity


@dataclass(frozen=True)
class Limits:
    """How long a goal bears what.

    Attributes:
        battery_stale_after: Silence of the battery that stops the wheels, in seconds.
        battery_lost_after: Silence of the battery that aborts the goal, in seconds.
        goal_timeout: The longest that a goal may take, in seconds; 0 is for ever.
    """

    battery_stale_after: float = 2.0
    battery_lost_after: float = 60.0
    goal_timeout: float = 0.0


@dataclass(frozen=True)
class Command:
    """The goal goes on.

    Attributes:
        stage: CONTROLLING or WAIT_FOR_BATTERY.
        velocity: What the wheels have to do until the next step.
        error_code: NONE, or why the goal waits.
        error_msg: The same as a sentence.
    """

    stage: Stage
    velocity: Velocity
    error_code: ErrorCode = ErrorCode.NONE
    error_msg: str = ""


class End(enum.StrEnum):
    """How a goal can end, in the words of ROS."""

    SUCCEEDED = "SUCCEEDED"
    CANCELED = "CANCELED"
    ABORTED = "ABORTED"

    @property
    def stage(self) -> Stage:
        """The stage that stands for this end."""
        return Stage(self.value)


@dataclass(frozen=True)
class Outcome:
    """The goal is over, and the wheels stand still.

    Attributes:
        end: How.
        error_code: NONE unless it was aborted.
        error_msg: The same as a sentence.
    """

    end: End
    error_code: ErrorCode = ErrorCode.NONE
    error_msg: str = ""


class DockGoal:
    """One accepted goal. It has one outcome, the first; whatever comes later changes nothing."""

    def __init__(self, controller: Controller, limits: Limits, started_at: float) -> None:
        """Start the goal.

        Args:
            controller: What moves the robot while the battery is not charging.
            limits: Its deadlines.
            started_at: Seconds of the monotonic clock.
        """
        self.outcome: Outcome | None = None
        self._controller = controller
        self._limits = limits
        self._started_at = started_at
        self._stepped_at = started_at

    def step(self, observation: Observation) -> Command | Outcome:
        """What to do now.

        A charger that is connected ends the goal well, but only a reading that is not stale can say so: one from
        before the goal counts as long as it is fresh.

        Args:
            observation: What is known now.
        """
        if self.outcome is not None:
            return self.outcome
        now, battery = observation.now, observation.battery
        stale = battery is None or battery.age(now) > self._limits.battery_stale_after
        if battery is not None and battery.connected and not stale:
            return self._finish(Outcome(End.SUCCEEDED))
        if 0.0 < self._limits.goal_timeout <= now - self._started_at:
            return self.abort(
                ErrorCode.TIMEOUT, f"the battery was not charging within {self._limits.goal_timeout:g} s (goal_timeout)"
            )
        return self._wait(now, battery) if stale else self._control(observation)

    def _control(self, observation: Observation) -> Command | Outcome:
        step = self._controller.step(observation, observation.now - self._stepped_at)
        self._stepped_at = observation.now
        if isinstance(step, Failed):
            return self.abort(step.error_code, step.error_msg)
        if isinstance(step, Done):
            return Command(Stage.CONTROLLING, STANDSTILL)
        if not step.finite:
            return self.abort(ErrorCode.FAILED_TO_CONTROL, f"the controller gave {step}")
        return Command(Stage.CONTROLLING, step)

    def _wait(self, now: float, battery: BatteryReading | None) -> Command | Outcome:
        heard_at = self._started_at if battery is None else max(self._started_at, battery.received_at)
        if now - heard_at > self._limits.battery_lost_after:
            return self.abort(
                ErrorCode.BATTERY_LOST,
                f"no battery message for {self._limits.battery_lost_after:g} s (battery_lost_after)",
            )
        message = (
            "no battery message has come yet: the wheels stand still"
            if battery is None
            else f"no battery message for over {self._limits.battery_stale_after:g} s: the wheels stand still"
        )
        return Command(Stage.WAIT_FOR_BATTERY, STANDSTILL, ErrorCode.BATTERY_STALE, message)

    def cancel(self) -> Outcome:
        """End it because someone asked for it."""
        return self._finish(Outcome(End.CANCELED))

    def abort(self, error_code: ErrorCode, error_msg: str) -> Outcome:
        """End it because it cannot go on."""
        return self._finish(Outcome(End.ABORTED, error_code, error_msg))

    def _finish(self, outcome: Outcome) -> Outcome:
        if self.outcome is None:
            self.outcome = outcome
        return self.outcome
