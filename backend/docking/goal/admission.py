"""Decides which goals are let in."""

from dataclasses import dataclass

from docking.core.battery import PowerSupplyStatus, describe_status
from docking.core.errors import ErrorCode
from docking.parameters import GoalPolicy


@dataclass(frozen=True)
class Purpose:
    """The purpose of the goals of an action.

    Attributes:
        statuses: Allowed desired statuses; UNKNOWN is a field that was not set.
        explanation: The same as the end of a sentence.
    """

    statuses: tuple[PowerSupplyStatus, ...]
    explanation: str


DOCKING = Purpose(
    (PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL, PowerSupplyStatus.UNKNOWN),
    "docking only accepts 1 (CHARGING) or 4 (FULL); 0 (not set) means CHARGING",
)
UNDOCKING = Purpose(
    (PowerSupplyStatus.DISCHARGING, PowerSupplyStatus.NOT_CHARGING, PowerSupplyStatus.UNKNOWN),
    "undocking only accepts 2 (DISCHARGING) or 3 (NOT_CHARGING); 0 (not set) means either",
)


@dataclass(frozen=True)
class Rejection:
    """The reason why a goal is not let in."""

    error_code: ErrorCode
    error_msg: str


def admit(
    desired_status: int,
    purpose: Purpose,
    *,
    active_goal_id: str | None,
    policy: GoalPolicy,
    stop_latched: bool,
    shutting_down: bool,
    active: bool = True,
) -> Rejection | None:
    """Decide on a goal.

    Args:
        desired_status: The goal's `desired_battery_state.power_supply_status`.
        purpose: The purpose of this action's goals.
        active_goal_id: The goal that runs, if one does.
        policy: What to do in that case.
        stop_latched: Whether a stop is latched.
        shutting_down: Whether the server is ending.
        active: Whether the server's node is active.

    Returns:
        None where the goal may run, else why it may not.
    """
    if shutting_down:
        return Rejection(ErrorCode.SHUTTING_DOWN, "the action server is shutting down")
    if not active:
        return Rejection(ErrorCode.NOT_ACTIVE, "the action server's node is not active: ros2 lifecycle set … activate")
    if desired_status not in purpose.statuses:
        return Rejection(
            ErrorCode.INVALID_GOAL,
            f"desired_battery_state.power_supply_status is {describe_status(desired_status)}, but"
            f" {purpose.explanation}",
        )
    if stop_latched:
        return Rejection(ErrorCode.STOP_LATCHED, "a stop is latched: nothing moves until it is released")
    if active_goal_id is not None and policy is GoalPolicy.REJECT:
        return Rejection(
            ErrorCode.DOCK_BUSY, f"goal {active_goal_id} is running; cancel it first, or set goal_policy to preempt"
        )
    return None
