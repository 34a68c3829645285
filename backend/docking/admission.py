"""Which goals are let in."""

import enum
from dataclasses import dataclass

from docking.battery import PowerSupplyStatus, describe_status
from docking.failures import ErrorCode

DESIRED = (PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL, PowerSupplyStatus.UNKNOWN)
"""What a goal may ask for; UNKNOWN is a field that was not set, and means CHARGING."""


class GoalPolicy(enum.StrEnum):
    """What happens to a goal that comes while another one runs."""

    REJECT = "reject"
    PREEMPT = "preempt"


@dataclass(frozen=True)
class Rejection:
    """Why a goal is not let in."""

    error_code: ErrorCode
    error_msg: str


def admit(
    desired_status: int, *, active_goal_id: str | None, policy: GoalPolicy, shutting_down: bool
) -> Rejection | None:
    """Decide on a goal.

    Args:
        desired_status: The goal's `desired_battery_state.power_supply_status`.
        active_goal_id: The goal that runs, if one does.
        policy: What to do in that case.
        shutting_down: Whether the server is ending.

    Returns:
        None where the goal may run, else why it may not.
    """
    if shutting_down:
        return Rejection(ErrorCode.SHUTTING_DOWN, "the action server is shutting down")
    if desired_status not in DESIRED:
        return Rejection(
            ErrorCode.INVALID_GOAL,
            f"desired_battery_state.power_supply_status is {describe_status(desired_status)}, but docking can only"
            " bring about 1 (CHARGING) or 4 (FULL); 0 (not set) means CHARGING",
        )
    if active_goal_id is not None and policy is GoalPolicy.REJECT:
        return Rejection(
            ErrorCode.DOCK_BUSY, f"goal {active_goal_id} is running; cancel it first, or set goal_policy to preempt"
        )
    return None
