"""The node `connect_to_charging_dock_action_client`: sends the tutorial's goal and prints what becomes of it."""

import sys
from collections.abc import Sequence

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.clients.battery_client import BatteryClient
from docking.clients.goal_client import run_client
from docking.core.battery import PowerSupplyStatus


class DockClient(BatteryClient):
    """A client of `connect_to_charging_dock`."""

    program = "connect_to_charging_dock_client"
    action_type = ConnectToChargingDock
    action_name = "connect_to_charging_dock"
    status = PowerSupplyStatus.CHARGING
    statuses = "1 CHARGING (default), 4 FULL, 0 not set"


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end; see `run_client`."""
    return run_client(DockClient, args)


if __name__ == "__main__":
    sys.exit(main())
