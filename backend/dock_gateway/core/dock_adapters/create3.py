"""iRobot Create 3 and TurtleBot 4: `Dock` and `Undock`.

Goals have no fields; the result says whether the robot is docked. The base finds the dock by its infrared beacon.
Feedback says whether it sees it; `Undock` sends none.
"""

from dataclasses import dataclass

from dock_gateway.core.dock_adapters.adapter import (
    DESIRED,
    DOCK_ID,
    DOCKED,
    UNDOCKED,
    DockAdapter,
    Fields,
    Outcome,
    Progress,
    invalid,
    refuse,
    take_battery,
)
from dock_gateway.core.errors import got
from dock_gateway.core.goal import GoalError, GoalStatus

FAMILY = "create3"
NO_NAMES = "this robot docks at the dock that it sees"


@dataclass(frozen=True)
class Create3Dock(DockAdapter):
    """Drives onto the dock that the robot sees."""

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Refuse the name of a dock."""
        refuse(request, [DOCK_ID], NO_NAMES, path)
        fields, battery = take_battery(request, DOCKED, path)
        if location := battery.get("location"):
            raise invalid(path, "desired_battery_state.location", f"no location: {NO_NAMES}", got(location))
        return fields

    def progress(self, feedback: Fields) -> Progress:
        """Return nav2's names of the two stages: searching for the dock, and driving onto it."""
        return Progress("CONTROLLING" if feedback.get("sees_dock") else "INITIAL_PERCEPTION")

    def outcome(self, status: GoalStatus, result: Fields) -> Outcome:
        """Judge by `is_docked`: the action succeeds whenever it comes to its end."""
        return _outcome(status, result, "failed_to_dock", wanted=True)


@dataclass(frozen=True)
class Create3Undock(DockAdapter):
    """Drives off the dock."""

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Refuse the name of a dock."""
        refuse(request, [DOCK_ID], "the robot leaves the dock that it is on", path)
        return take_battery(request, UNDOCKED, path)[0]

    def outcome(self, status: GoalStatus, result: Fields) -> Outcome:
        """Judge by `is_docked`."""
        return _outcome(status, result, "failed_to_undock", wanted=False)


def _outcome(status: GoalStatus, result: Fields, code: str, *, wanted: bool) -> Outcome:
    docked = result.get("is_docked", wanted)
    if status is GoalStatus.CANCELED or (status is GoalStatus.SUCCEEDED and docked is wanted):
        return Outcome(status)
    ended = "ended the goal" if status is GoalStatus.SUCCEEDED else "gave up"
    detail = f"the robot {ended} and reports that it is {'docked' if docked else 'not docked'}"
    return Outcome(GoalStatus.ABORTED, GoalError(code, detail))


DOCK = Create3Dock(
    "dock",
    FAMILY,
    "irobot_create_msgs/action/Dock",
    "dock",
    takes=(DESIRED,),
    tells_stage=True,
)
UNDOCK = Create3Undock("undock", FAMILY, "irobot_create_msgs/action/Undock", "undock", takes=(DESIRED,))
