"""The node `connect_to_charging_dock_action_client`: sends the tutorial's goal and prints what becomes of it."""

import sys
from collections.abc import Sequence
from functools import partial

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.clients.battery_client import BatteryAction, run_battery_client
from docking.core.battery import PowerSupplyStatus
from docking.ros.process import run_process

ACTION = BatteryAction(
    type=ConnectToChargingDock,
    name="connect_to_charging_dock",
    program="connect_to_charging_dock_client",
    status=PowerSupplyStatus.CHARGING,
    statuses="1 CHARGING (default), 4 FULL, 0 not set",
)


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end.

    Args:
        args: The command line, the program's name first; None is that of the process.

    Returns:
        The exit code, one of `docking.clients.session.ExitCode` or 2.
    """
    return run_process(partial(run_battery_client, ACTION), args)


if __name__ == "__main__":
    sys.exit(main())
