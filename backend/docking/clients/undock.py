"""The node `disconnect_from_charging_dock_action_client`: sends a goal to undock and prints what becomes of it."""

import sys
from collections.abc import Sequence

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.clients.battery_client import BatteryClient
from docking.clients.goal_client import run_client
from docking.core.battery import PowerSupplyStatus


class UndockClient(BatteryClient):
    """A client of `disconnect_from_charging_dock`."""

    program = "disconnect_from_charging_dock_client"
    action_type = DisconnectFromChargingDock
    action_name = "disconnect_from_charging_dock"
    status = PowerSupplyStatus.NOT_CHARGING
    statuses = "3 NOT_CHARGING (default), 2 DISCHARGING, 0 not set"


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end; see `run_client`."""
    return run_client(UndockClient, args)


if __name__ == "__main__":
    sys.exit(main())
