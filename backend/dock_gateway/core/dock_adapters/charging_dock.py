"""Our own `ConnectToChargingDock` and `DisconnectFromChargingDock`: the battery says whether the robot is docked.

Their servers report stages, retries and reasons on `/diagnostics`; feedback and result hold the battery state only.
"""

from dataclasses import dataclass

from dock_gateway.core.dock_adapters.adapter import DESIRED, DOCK_ID, DockAdapter, Fields, choose_dock, refuse

FAMILY = "charging_dock"
CHARGING = {"power_supply_status": 1}


@dataclass(frozen=True)
class ConnectToChargingDock(DockAdapter):
    """Drives until the battery is charging. `desired_battery_state.location` names the dock."""

    @property
    def default(self) -> Fields:
        """An empty body asks for CHARGING."""
        return {DESIRED: CHARGING}

    def goal(self, request: Fields, default_dock: str = "", path: str = "") -> Fields:
        """Name the dock in `desired_battery_state.location`."""
        desired = request.get(DESIRED, CHARGING if DOCK_ID in request else {})
        if not isinstance(desired, dict):  # the codec reports the error
            return request
        dock = choose_dock(request, desired.get("location"), path) or default_dock
        if not dock:
            return request
        return {name: value for name, value in request.items() if name != DOCK_ID} | {
            DESIRED: {**desired, "location": dock}
        }


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
    "dock", FAMILY, "action_tutorials_interfaces/action/ConnectToChargingDock", "connect_to_charging_dock"
)
UNDOCK = DisconnectFromChargingDock(
    "undock",
    FAMILY,
    "action_tutorials_interfaces/action/DisconnectFromChargingDock",
    "disconnect_from_charging_dock",
)
