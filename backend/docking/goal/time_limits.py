"""Limits the time of a goal: each moment counts once, for its stage, for the search or as waiting."""

import math

from docking.core.errors import DockingError, Stage
from docking.goal.objective import Objective
from docking.goal.plan import Plan, RecoveringPlan


class TimeLimits:
    """Counts the time of one goal against its limits.

    The time of a stage stands still while the robot waits, and nothing resets it before the next stage. A wait has a
    limit of its own, which begins again when what was waited for comes back. So all waits together have a limit, too: a
    goal waits no longer than it goes on otherwise and `patience`, twice the limits of the single waits. A plan that
    drives blindly, as `rotate`, has no limits of stages, and so none of this kind.
    """

    def __init__(self, plan: Plan, objective: Objective, obstacle_timeout: float = 0.0) -> None:
        """Begin at no time.

        Args:
            plan: The stages.
            objective: Their time limits.
            obstacle_timeout: The longest wait for an obstacle, in s; 0 where none are watched.
        """
        self._plan = plan
        self._objective = objective
        self._patience = 2.0 * (
            (objective.timeouts.battery_lost_after if objective.needs_battery else 0.0)
            + (math.inf if plan.motion is None else objective.timeouts.odometry_timeout)
            + obstacle_timeout
        )
        self._elapsed = self._waited = 0.0
        self._stage = self._search = 0.0

    def enter(self) -> None:
        """A stage begins."""
        self._stage = self._search = 0.0

    def elapse(self, dt: float) -> None:
        """Time passes, whatever for."""
        self._elapsed += dt

    def wait(self, dt: float) -> str:
        """Time has passed that the robot waited for.

        Args:
            dt: In s.

        Returns:
            Why the robot must not wait any longer, as the end of a sentence; empty while it may.
        """
        self._waited += dt
        if self._waited <= self._patience + self._elapsed - self._waited:
            return ""
        return f"it has waited {self._waited:.0f} s of {self._elapsed:.0f} s: what it waits for comes and goes"

    def count(self, dt: float, *, searches: bool = False) -> None:
        """Time has passed for the stage.

        Args:
            dt: In s.
            searches: Whether the robot drove about to find the dock.
        """
        if searches:
            self._search += dt
        else:
            self._stage += dt

    def exceeded(self, stage: Stage, *, finished: bool) -> DockingError | None:
        """The error of a stage that has taken too long; None while it may go on, and for plans that drive blindly.

        Args:
            stage: The current one.
            finished: Whether its behavior is done.
        """
        if self._plan.motion is None:
            return None
        limits = (self._objective.deadline(stage, finished), self._stage), (self._objective.search, self._search)
        for deadline, seconds in limits:
            if deadline is not None and seconds > deadline.seconds:
                return deadline.error(f"{deadline.message} within {deadline.seconds:g} s ({deadline.parameter})")
        return None

    def longest(self, before: float = 0.0) -> float:
        """The seconds after which the goal has ended, whatever happens; infinite where nothing limits it.

        Args:
            before: The limits, in s, of what comes before the first stage: navigation, the marker's detector.
        """
        return longest(self._plan, self._objective, self._patience, before)


def longest(plan: Plan, objective: Objective, patience: float, before: float = 0.0) -> float:
    """The seconds after which a goal has ended, whatever happens; infinite where nothing limits it.

    Each attempt takes at most the limits of its stages. Between attempts the robot backs off, on the contacts it
    presses again, in the end it goes back. A charge that is not stable yet lets a stage take longer. The robot may wait
    as long as all of that takes, and `patience`.

    Args:
        plan: The stages.
        objective: The time limits.
        patience: Twice the limits of the single waits, in s.
        before: The limits, in s, of what comes before the first stage: navigation, the marker's detector.
    """
    goal_timeout = objective.timeouts.goal_timeout or math.inf
    if plan.motion is None:
        return goal_timeout
    retries, recovery = objective.max_retries, objective.recovery
    search = 0.0 if objective.search is None else objective.search.seconds
    driven = before + (retries + 1) * (sum(map(objective.limit, plan.stages)) + search)
    driven += retries * objective.limit(Stage.RETRY) if retries else 0.0
    failures = retries + 2
    if recovery is not None and isinstance(plan, RecoveringPlan):
        again = objective.limit(Stage.CORRECTING) + objective.limit(plan.stages[-1])
        driven += recovery.max_corrections * again + objective.limit(Stage.RETURN_TO_STAGING)
        failures += recovery.max_corrections
    return min(goal_timeout, 2.0 * (driven + objective.held(failures)) + patience)
