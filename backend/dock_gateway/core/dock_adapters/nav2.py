"""nav2's docking server (opennav_docking, from Jazzy to its main branch): `DockRobot` and `UndockRobot`.

It accepts every goal while it is active, and checks it afterwards: an unknown dock is an aborted goal. A goal that
arrives while another one runs replaces it. The result has an error code, which is 0 if the server gave up for another
reason; feedback has the stage and the number of retries. `UndockRobot` sends no feedback.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from dock_gateway.core.dock_adapters.adapter import (
    DESIRED,
    DOCK_ID,
    DOCKED,
    NO_REASON,
    POSE,
    UNDOCKED,
    USE_ID,
    DockAdapter,
    Fields,
    Outcome,
    Progress,
    choose_dock,
    invalid,
    refuse,
    take_battery,
)
from dock_gateway.core.goal import GoalError, GoalStatus

FAMILY = "nav2"
# Characters of the server's own sentence.
MAX_MESSAGE = 500

STAGES = {
    1: "NAV_TO_STAGING_POSE",
    2: "INITIAL_PERCEPTION",
    3: "CONTROLLING",
    4: "WAIT_FOR_CHARGE",
    5: "RETRY",
}

Errors = Mapping[int, tuple[str, str]]
UNKNOWN = ("unknown", "an unexpected error in the docking server; its log says more")
TIMEOUT = ("timeout", "the goal took longer than it may")
# nav2's server itself never sends these two; what passes goals on to it does, such as a behavior tree.
PASSED_ON: Errors = {
    1: ("goal_rejected", "the docking server's goal was passed on, and rejected"),
    2: ("send_goal_failure", "the docking server's goal could not be passed on"),
}
DOCK_ERRORS: Errors = {
    0: (
        NO_REASON,
        "the docking server gave up without an error code, as it does when a newer goal replaces this one",
    ),
    **PASSED_ON,
    901: ("dock_not_in_db", "the docking server has no dock of that name in its database"),
    902: ("dock_not_valid", "the docking server has no plugin for the type of this dock"),
    903: ("failed_to_stage", "the staging pose in front of the dock was not reached"),
    904: ("failed_to_detect_dock", "the dock was not detected"),
    905: ("failed_to_control", "the dock was not reached"),
    906: ("failed_to_charge", "the robot is on the dock, but its battery did not start to charge"),
    907: TIMEOUT,
    999: UNKNOWN,
}
UNDOCK_ERRORS: Errors = {
    0: (
        NO_REASON,
        "the docking server gave up without an error code, as it does when the robot is not on a dock",
    ),
    **PASSED_ON,
    902: (
        "dock_not_valid",
        "the docking server does not know the type of the dock that the robot is on; name it with dock_type",
    ),
    905: ("failed_to_undock", "the robot did not get off the dock in time, or still charges"),
    907: TIMEOUT,
    999: UNKNOWN,
}


@dataclass(frozen=True)
class DockRobot(DockAdapter):
    """Docks at a dock of the server's database, by name, or at a pose."""

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Set `use_dock_id` to what the request contains: a pose that was left out would be all zeros."""
        fields, battery = take_battery(request, DOCKED, path)
        by_id = fields.get(USE_ID)
        if by_id is False:
            if POSE not in fields:
                raise invalid(path, POSE, f"the pose of the dock, as {USE_ID} is false", "got none")
            return fields
        dock = choose_dock(fields, battery.get("location"), path)
        if POSE in fields and by_id is None:
            if dock:
                raise invalid(path, USE_ID, f"true or false, as there are both {DOCK_ID} and {POSE}", "got none")
            return {**fields, USE_ID: False}
        if not dock and not default_dock:
            return fields
        return {**fields, DOCK_ID: dock or default_dock}

    def dock_of(self, goal: Fields) -> str | None:
        """Read `dock_id`, unless the pose counts."""
        return str(goal.get(DOCK_ID, "")) if goal.get(USE_ID) else None

    def at_dock(self, goal: Fields, dock: str) -> Fields:
        """Set `dock_id`."""
        return {**goal, DOCK_ID: dock}

    def progress(self, feedback: Fields) -> Progress:
        """Read the state, and the number of retries."""
        return Progress(STAGES.get(feedback.get("state", 0)), feedback.get("num_retries"))

    def outcome(self, status: GoalStatus, result: Fields) -> Outcome:
        """Read the error code, and the number of retries."""
        return _outcome(status, result, DOCK_ERRORS, result.get("num_retries"))


@dataclass(frozen=True)
class UndockRobot(DockAdapter):
    """Undocks. The server has to know the type of the dock, from the last docking or from the goal."""

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Refuse the name of a dock: the message has its type only."""
        refuse(request, [DOCK_ID], "the robot leaves the dock that it is on; nav2 may need its dock_type", path)
        return take_battery(request, UNDOCKED, path)[0]

    def outcome(self, status: GoalStatus, result: Fields) -> Outcome:
        """Read the error code."""
        return _outcome(status, result, UNDOCK_ERRORS, None)


def _outcome(status: GoalStatus, result: Fields, errors: Errors, retries: int | None) -> Outcome:
    if status is GoalStatus.SUCCEEDED and not result.get("success", True):
        status = GoalStatus.ABORTED
    if status is not GoalStatus.ABORTED:
        return Outcome(status, None, retries)
    number, message = result.get("error_code", 0), result.get("error_msg", "")
    code, detail = errors.get(number) or (UNKNOWN[0], f"the docking server's error {number}, which is not documented")
    return Outcome(status, GoalError(code, f"{detail}: {message[:MAX_MESSAGE]}" if message else detail), retries)


DOCK = DockRobot(
    "dock",
    FAMILY,
    "nav2_msgs/action/DockRobot",
    "dock_robot",
    takes=(DESIRED,),
    tells_stage=True,
)
UNDOCK = UndockRobot("undock", FAMILY, "nav2_msgs/action/UndockRobot", "undock_robot", takes=(DESIRED,))
