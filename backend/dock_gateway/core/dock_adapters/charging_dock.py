"""Our own `ConnectToChargingDock` and `DisconnectFromChargingDock`: the battery says whether the robot is docked.

Their servers report stages, retries and reasons on `/diagnostics`; feedback and result hold the battery state only.
"""

import json
from dataclasses import dataclass

from dock_gateway.core.dock_adapters.adapter import (
    DESIRED,
    DOCK_ID,
    POSE,
    TYPE,
    USE_ID,
    DockAdapter,
    Fields,
    choose_dock,
    invalid,
    refuse,
)
from dock_gateway.core.errors import got
from dock_gateway.core.scene import Pose

FAMILY = "charging_dock"
CHARGING = {"power_supply_status": 1}
# In place of a name, the server takes this: the dock that the robot is nearest to.
NEAREST = "nearest"


@dataclass(frozen=True)
class ConnectToChargingDock(DockAdapter):
    """Drives until the battery is charging. `desired_battery_state.location` names the dock, or describes it."""

    @property
    def default(self) -> Fields:
        """An empty body asks for CHARGING."""
        return {DESIRED: CHARGING}

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Name the dock in `desired_battery_state.location`, or describe it there, if the request has its pose."""
        named = DOCK_ID in request or POSE in request
        desired = request.get(DESIRED, CHARGING if named else {})
        if not isinstance(desired, dict):  # the codec reports the error
            return request
        own = {DOCK_ID} if POSE not in request else {DOCK_ID, POSE, TYPE, USE_ID}
        dock = choose_dock(request, desired.get("location"), path)
        if POSE in request and request.get(USE_ID) is not True:
            if dock and USE_ID not in request:
                raise invalid(path, USE_ID, f"true or false, as there are both {DOCK_ID} and {POSE}", "got none")
            dock = _describe(request, path)
        dock = dock or default_dock
        if not dock:
            return request
        return {name: value for name, value in request.items() if name not in own} | {
            DESIRED: {**desired, "location": dock}
        }

    def dock_of(self, goal: Fields) -> str | None:
        """Read `location`: it is a name, unless it describes the dock."""
        location: str = goal.get(DESIRED, {}).get("location", "")
        if location.lstrip().startswith("{"):
            return None
        return "" if location == NEAREST else location

    def at_dock(self, goal: Fields, dock: str) -> Fields:
        """Set `location`."""
        return {**goal, DESIRED: {**goal.get(DESIRED, {}), "location": dock}}


def _describe(request: Fields, path: str) -> str:
    """The dock at a pose, as our docking server reads it.

    Raises:
        InvalidField: The pose or the type is none.
    """
    header, pose, kind = request[POSE]["header"], request[POSE]["pose"], request.get(TYPE, "")
    if not isinstance(kind, str):
        raise invalid(path, TYPE, "the name of a type of docks", got(kind))
    if not header["frame_id"]:
        raise invalid(path, f"{POSE}.header.frame_id", "the frame of the pose, such as map", "got none")
    position, turn = pose["position"], pose["orientation"]
    try:
        place = Pose.in_plane(position["x"], position["y"], (turn["x"], turn["y"], turn["z"], turn["w"]))
    except (TypeError, ValueError) as error:  # a NaN is null
        raise invalid(path, f"{POSE}.pose", "a pose in the plane", str(error)) from None
    dock = {"frame": header["frame_id"], "pose": [round(number, 6) for number in place]}
    return json.dumps(dock | ({"type": kind} if kind else {}))


@dataclass(frozen=True)
class DisconnectFromChargingDock(DockAdapter):
    """Drives off the dock until the battery is no longer charging."""

    @property
    def default(self) -> Fields:
        """An empty body asks for a battery that is not charging."""
        return {DESIRED: {}}

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Refuse the name of a dock: the robot leaves the one that it is on."""
        refuse(request, [DOCK_ID], "the robot leaves the dock that it is on", path)
        return request


DOCK = ConnectToChargingDock(
    "dock",
    FAMILY,
    "action_tutorials_interfaces/action/ConnectToChargingDock",
    "connect_to_charging_dock",
    takes=(DOCK_ID, POSE, TYPE, USE_ID),
)
UNDOCK = DisconnectFromChargingDock(
    "undock",
    FAMILY,
    "action_tutorials_interfaces/action/DisconnectFromChargingDock",
    "disconnect_from_charging_dock",
)
