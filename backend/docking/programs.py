"""The programs that users start, by name. What ROS lacks ends one in a sentence, before anything of ROS is imported."""

import importlib
import os
import sys
from pathlib import Path

from robot_io.installation import DOCKING, MESSAGES
from robot_io.startup import find_docking_fault, find_load_fault, find_start_fault

EXIT_UNUSABLE = 2
"""Exit code: ROS is missing or wrong; the same as for a wrong command line."""

MODULES = {
    "connect_to_charging_dock_server": "docking.nodes.dock_server",
    "connect_to_charging_dock_client": "docking.clients.dock",
    "disconnect_from_charging_dock_client": "docking.clients.undock",
    "docking_server": "docking.nodes.docking_server",
    "dock_simulator": "docking.nodes.simulator",
    "docking_replay": "docking.nodes.replay",
    "fibonacci_action_server": "docking.tutorial.fibonacci_server",
    "fibonacci_action_client": "docking.tutorial.fibonacci_client",
}
"""The module of each program, which has a `main`."""


def main() -> int:
    """Run the program by whose name the process was started.

    Returns:
        The exit code: that of the program, or `EXIT_UNUSABLE`.
    """
    fault = find_start_fault(os.environ) or find_docking_fault(os.environ)
    if fault := fault or find_load_fault(os.environ, (*MESSAGES, DOCKING)):
        print(f"error: {fault}", file=sys.stderr)  # noqa: T201 - there is no node to log with
        return EXIT_UNUSABLE
    code: int = importlib.import_module(MODULES[Path(sys.argv[0]).name]).main()
    return code
