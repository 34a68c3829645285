"""The node `connect_to_charging_dock_action_client`: sends the tutorial's goal and prints what becomes of it."""

import argparse
import math
import sys
from collections.abc import Callable, Sequence

from rclpy.context import Context
from rclpy.utilities import remove_ros_args

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.battery import PowerSupplyStatus
from docking.ros.goal_client import GoalClient, run_client
from docking.ros.process import run_process
from docking.session import Patience

LARGEST_FLOAT32 = 3.4028234663852886e38
LEGEND = "(1 = CHARGING, 3 = NOT CHARGING)"


class DockClient(GoalClient):
    """A client of `connect_to_charging_dock`."""

    def __init__(
        self,
        goal: ConnectToChargingDock.Goal,
        *,
        patience: Patience,
        on_over: Callable[[], None],
        context: Context | None = None,
    ) -> None:
        """Make the node; see GoalClient."""
        super().__init__(
            "connect_to_charging_dock_action_client",
            ConnectToChargingDock,
            "connect_to_charging_dock",
            goal,
            patience=patience,
            on_over=on_over,
            context=context,
        )

    def accepted_text(self) -> str:
        """In the tutorial's words."""
        return "Goal accepted..."

    def feedback_text(self, feedback: ConnectToChargingDock.Feedback) -> str:
        """In the tutorial's words."""
        return f"Received feedback {LEGEND}: {feedback.current_battery_state.power_supply_status}"

    def result_text(self, result: ConnectToChargingDock.Result) -> str:
        """In the tutorial's words."""
        return f"Result {LEGEND}: {result.final_battery_state.power_supply_status}"


def _float32(text: str) -> float:
    value = float(text)
    if not math.isnan(value) and abs(value) > LARGEST_FLOAT32:
        raise argparse.ArgumentTypeError(f"{text} is not a float32")
    return value


def _status(text: str) -> int:
    value = int(text)
    if not 0 <= value <= 255:
        raise argparse.ArgumentTypeError(f"{text} is not between 0 and 255")
    return value


def seconds(text: str) -> float:
    """A duration from the command line, in seconds."""
    value = float(text)
    if not 0.0 < value <= 86400.0:
        raise argparse.ArgumentTypeError(f"{text} is not between 0 and 86400 seconds")
    return value


def parse_arguments(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line without its ROS arguments; exits with 2 where it is wrong."""
    parser = argparse.ArgumentParser(
        prog="connect_to_charging_dock_client",
        description="Send a goal to the action server connect_to_charging_dock and print its feedback and result.",
        epilog="Exit codes: 0 succeeded, 1 aborted, 2 usage, 3 rejected, 4 canceled, 5 no server, 6 server lost,"
        " 130 interrupted. Ctrl-C cancels the goal.",
    )
    parser.add_argument("--voltage", type=_float32, default=2.16, metavar="V", help="desired voltage (default 2.16)")
    parser.add_argument(
        "--percentage", type=_float32, default=0.24, metavar="0…1", help="desired charge (default 0.24)"
    )
    parser.add_argument(
        "--status",
        type=_status,
        default=int(PowerSupplyStatus.CHARGING),
        metavar="N",
        help="desired power_supply_status: 1 CHARGING (default), 4 FULL, 0 not set",
    )
    parser.add_argument(
        "--timeout", type=seconds, default=10.0, metavar="S", help="how long to wait for a server (default 10 s)"
    )
    return parser.parse_args(arguments)


def _run(args: Sequence[str] | None) -> int:
    command_line = list(sys.argv if args is None else args)
    options = parse_arguments(remove_ros_args(command_line)[1:])
    goal = ConnectToChargingDock.Goal()
    goal.desired_battery_state.voltage = options.voltage
    goal.desired_battery_state.percentage = options.percentage
    goal.desired_battery_state.power_supply_status = options.status
    patience = Patience(server=options.timeout)
    return run_client(
        lambda context, on_over: DockClient(goal, patience=patience, on_over=on_over, context=context), command_line
    )


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end.

    Args:
        args: The command line, the program's name first; None is that of the process.

    Returns:
        The exit code, one of `docking.session.ExitCode` or 2.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
