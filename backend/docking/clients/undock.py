"""The node `disconnect_from_charging_dock_action_client`: sends a goal to undock and prints what becomes of it."""

import sys
from collections.abc import Sequence
from functools import partial

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.clients.battery_client import BatteryAction, run_battery_client
from docking.core.battery import PowerSupplyStatus
from docking.ros.process import run_process

ACTION = BatteryAction(
    type=DisconnectFromChargingDock,
    name="disconnect_from_charging_dock",
    program="disconnect_from_charging_dock_client",
    status=PowerSupplyStatus.NOT_CHARGING,
    statuses="3 NOT_CHARGING (default), 2 DISCHARGING, 0 not set",
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
