"""Stages of docking, and all that can go wrong: a code, a number and an exception each, all in one place.

Words and numbers are those of nav2's docking server (nav2_msgs/action/DockRobot and UndockRobot) where it has them;
the numbers from 950 on are our own, below nav2's UNKNOWN.
"""

import enum
from typing import ClassVar, Self


class Stage(enum.StrEnum):
    """The current stage of docking, or how the last goal ended."""

    IDLE = "IDLE"
    """No goal has come yet."""
    INITIAL_PERCEPTION = "INITIAL_PERCEPTION"
    """The dock is looked for, by turning if need be."""
    NAV_TO_STAGING_POSE = "NAV_TO_STAGING_POSE"
    """The robot drives to its staging pose in front of the dock."""
    CONTROLLING = "CONTROLLING"
    """A controller moves the robot towards the dock."""
    WAIT_FOR_CHARGE = "WAIT_FOR_CHARGE"
    """The robot stands on the dock and waits for its battery to charge."""
    RETRY = "RETRY"
    """The robot backs off, to try again."""
    CORRECTING = "CORRECTING"
    """The battery does not charge on the contacts: the robot backs a little, turns a little and presses again."""
    RETURN_TO_STAGING = "RETURN_TO_STAGING"
    """The last attempt has failed, and the robot goes back to its staging pose before the goal is aborted."""
    UNDOCKING = "UNDOCKING"
    """The robot backs out of the dock."""
    WAIT_FOR_CLEARANCE = "WAIT_FOR_CLEARANCE"
    """An obstacle is in the way, or there is no scan, so the wheels stand still; the goal goes on."""
    WAIT_FOR_BATTERY = "WAIT_FOR_BATTERY"
    """The battery is silent, so the wheels stand still; the goal goes on."""
    WAIT_FOR_ODOMETRY = "WAIT_FOR_ODOMETRY"
    """Odometry is silent, so the wheels stand still; the goal goes on."""
    SUCCEEDED = "SUCCEEDED"
    CANCELED = "CANCELED"
    ABORTED = "ABORTED"
    REJECTED = "REJECTED"


class ErrorCode(enum.StrEnum):
    """The reason why a goal waits, was aborted or was rejected.

    Attributes:
        number: The number that stands for it: nav2's where nav2 has one.
    """

    number: int

    def __new__(cls, code: str, number: int) -> Self:
        """A member: its name in ROS, and its number."""
        member = str.__new__(cls, code)
        member._value_ = code
        member.number = number
        return member

    NONE = "NONE", 0
    """Nothing is wrong."""
    DOCK_BUSY = "DOCK_BUSY", 950
    """Rejected: another goal is running and goal_policy is `reject`."""
    INVALID_GOAL = "INVALID_GOAL", 951
    """Rejected: the desired power_supply_status is not one that docking can bring about."""
    DOCK_NOT_IN_DB = "DOCK_NOT_IN_DB", 901
    """Rejected: the goal names a dock that is not one of `docks`."""
    DOCK_NOT_VALID = "DOCK_NOT_VALID", 902
    """Rejected: the goal describes a dock instead of naming one, and its type, frame or pose is none."""
    SHUTTING_DOWN = "SHUTTING_DOWN", 952
    """Rejected or aborted: the action server is ending."""
    STOP_LATCHED = "STOP_LATCHED", 953
    """Rejected or aborted: a stop is latched, and nothing may move until it is released."""
    NOT_ACTIVE = "NOT_ACTIVE", 955
    """Rejected or aborted: the action server's node is not active (its lifecycle state)."""
    BATTERY_STALE = "BATTERY_STALE", 960
    """Waiting: no battery message for battery_stale_after."""
    BATTERY_LOST = "BATTERY_LOST", 961
    """Aborted: no battery message for battery_lost_after."""
    TIMEOUT = "TIMEOUT", 907
    """Aborted: goal_timeout is over."""
    PREEMPTED = "PREEMPTED", 954
    """Aborted: a newer goal took over and goal_policy is `preempt`."""
    FAILED_TO_STAGE = "FAILED_TO_STAGE", 903
    """Aborted: the staging pose was not reached in time, or navigate_to_pose failed."""
    FAILED_TO_DETECT_DOCK = "FAILED_TO_DETECT_DOCK", 904
    """Aborted: the dock was not found in time."""
    FAILED_TO_CONTROL = "FAILED_TO_CONTROL", 905
    """Aborted: the dock was not reached in time, or the controller gave a velocity that is not a number."""
    FAILED_TO_CHARGE = "FAILED_TO_CHARGE", 906
    """Aborted: the robot is on the dock, but its battery does not charge."""
    LOST_MARKER = "LOST_MARKER", 962
    """Aborted: the marker on the dock was seen, and then no longer."""
    INFRARED_LOST = "INFRARED_LOST", 963
    """Aborted: the dock's infrared beacon was seen, and then no longer, or the receivers are silent."""
    LOCALIZATION_LOST = "LOCALIZATION_LOST", 966
    """Aborted: the localization that says where the dock is has fallen silent, or does not know where the robot is."""
    BLOCKED = "BLOCKED", 970
    """Aborted: the robot did not move as commanded, or not at all."""
    PUSHED_OFF = "PUSHED_OFF", 971
    """Aborted: the robot was on the dock, and was moved away from it."""
    ODOMETRY_LOST = "ODOMETRY_LOST", 964
    """Waiting: no odometry for over 1 s. Aborted: for odometry_timeout."""
    SCAN_LOST = "SCAN_LOST", 965
    """Waiting: no scan for scan_timeout. Aborted: for obstacle_timeout."""
    OBSTRUCTED = "OBSTRUCTED", 974
    """Waiting: an obstacle is in the way. Aborted: for obstacle_timeout."""
    FAILED_TO_UNDOCK = "FAILED_TO_UNDOCK", 972
    """Aborted: the robot did not get away from the dock in time, or its battery is charging still."""
    DOCKED_UNKNOWN = "DOCKED_UNKNOWN", 973
    """Aborted: nothing tells whether the robot is docked, so that it must not back out."""
    UNKNOWN = "UNKNOWN", 999
    """Aborted: an unexpected error; the log has it."""


class DockingError(Exception):
    """Something went wrong on the way to the dock or away from it.

    Attributes:
        error_code: Its code.
        worth_a_retry: Whether backing off and trying again may help.
    """

    error_code: ClassVar[ErrorCode]
    worth_a_retry: ClassVar[bool] = True


class DockNotInDb(DockingError):
    """The goal names a dock that is not known."""

    error_code = ErrorCode.DOCK_NOT_IN_DB
    worth_a_retry = False


class DockNotValid(DockingError):
    """The goal describes a dock that cannot be one."""

    error_code = ErrorCode.DOCK_NOT_VALID
    worth_a_retry = False


class FailedToStage(DockingError):
    """The staging pose was not reached in time, or another server did not get there."""

    error_code = ErrorCode.FAILED_TO_STAGE
    worth_a_retry = False


class FailedToDetectDock(DockingError):
    """The dock was not found in time."""

    error_code = ErrorCode.FAILED_TO_DETECT_DOCK
    worth_a_retry = False


class FailedToControl(DockingError):
    """The dock was not reached in time, or not straight enough."""

    error_code = ErrorCode.FAILED_TO_CONTROL


class FailedToCharge(DockingError):
    """The robot is on the dock, but its battery does not charge."""

    error_code = ErrorCode.FAILED_TO_CHARGE


class LostMarker(DockingError):
    """The marker on the dock was seen, and then no longer."""

    error_code = ErrorCode.LOST_MARKER


class InfraredLost(DockingError):
    """The dock's beacon was seen, and then no longer, or the receivers are silent."""

    error_code = ErrorCode.INFRARED_LOST


class LocalizationLost(DockingError):
    """The localization that says where the dock is was heard, and then no longer."""

    error_code = ErrorCode.LOCALIZATION_LOST


class OdometryLost(DockingError):
    """No odometry comes, without which the robot can neither back off nor try again."""

    error_code = ErrorCode.ODOMETRY_LOST
    worth_a_retry = False


class ScanLost(DockingError):
    """There was no scan for too long, without which the robot does not drive."""

    error_code = ErrorCode.SCAN_LOST
    worth_a_retry = False


class Obstructed(DockingError):
    """An obstacle was in the way for too long."""

    error_code = ErrorCode.OBSTRUCTED
    worth_a_retry = False


class Blocked(DockingError):
    """The robot did not move as commanded, or not at all."""

    error_code = ErrorCode.BLOCKED


class OdometryJumped(Blocked):
    """Odometry says that the robot is where it cannot be: nothing tells that it has run into something."""


class PushedOff(DockingError):
    """The robot was on the dock, and was moved away from it."""

    error_code = ErrorCode.PUSHED_OFF


class FailedToUndock(DockingError):
    """The robot did not get away from the dock in time, or its battery is charging still."""

    error_code = ErrorCode.FAILED_TO_UNDOCK
    worth_a_retry = False


class DockedUnknown(DockingError):
    """Nothing tells whether the robot is docked."""

    error_code = ErrorCode.DOCKED_UNKNOWN
    worth_a_retry = False
