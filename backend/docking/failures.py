"""Stages of docking and the codes of what can go wrong, all in one place.

The words follow nav2's docking server where it has one (`error_code`, `error_msg`, stage CONTROLLING, …).
"""

import enum


class Stage(enum.StrEnum):
    """What docking is doing, or how the last goal ended."""

    IDLE = "IDLE"
    """No goal has come yet."""
    CONTROLLING = "CONTROLLING"
    """A controller moves the robot."""
    WAIT_FOR_BATTERY = "WAIT_FOR_BATTERY"
    """The battery is silent, so the wheels stand still; the goal goes on."""
    SUCCEEDED = "SUCCEEDED"
    CANCELED = "CANCELED"
    ABORTED = "ABORTED"
    REJECTED = "REJECTED"


class ErrorCode(enum.StrEnum):
    """Why a goal waits, was aborted or was rejected."""

    NONE = "NONE"
    """Nothing is wrong."""
    DOCK_BUSY = "DOCK_BUSY"
    """Rejected: another goal is running and goal_policy is `reject`."""
    INVALID_GOAL = "INVALID_GOAL"
    """Rejected: the desired power_supply_status is not one that docking can bring about."""
    SHUTTING_DOWN = "SHUTTING_DOWN"
    """Rejected or aborted: the action server is ending."""
    BATTERY_STALE = "BATTERY_STALE"
    """Waiting: no battery message for battery_stale_after."""
    BATTERY_LOST = "BATTERY_LOST"
    """Aborted: no battery message for battery_lost_after."""
    TIMEOUT = "TIMEOUT"
    """Aborted: goal_timeout is over."""
    PREEMPTED = "PREEMPTED"
    """Aborted: a newer goal took over and goal_policy is `preempt`."""
    FAILED_TO_CONTROL = "FAILED_TO_CONTROL"
    """Aborted: the controller gave a velocity that is not a number."""
    UNKNOWN = "UNKNOWN"
    """Aborted: an unexpected error; the log has it."""
