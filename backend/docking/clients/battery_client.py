"""What the clients for docking and undocking have in common: goal, feedback and result hold a battery state each."""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rclpy.context import Context
from rclpy.utilities import remove_ros_args

from docking.clients.goal_client import GoalClient, add_timeout, client_parser, run_client
from docking.clients.session import Patience
from docking.core.battery import PowerSupplyStatus

LARGEST_FLOAT32 = 3.4028234663852886e38
LEGEND = "(1 = CHARGING, 3 = NOT CHARGING)"


@dataclass(frozen=True)
class BatteryAction:
    """An action of that kind, as its client knows it.

    Attributes:
        type: The generated class.
        name: Relative, so that it can be remapped.
        program: The client's.
        status: What a goal asks for by default.
        statuses: What it can ask for, for the help text.
    """

    type: Any
    name: str
    program: str
    status: PowerSupplyStatus
    statuses: str


class BatteryClient(GoalClient):
    """A client of such an action."""

    def __init__(
        self,
        action: BatteryAction,
        goal: Any,
        *,
        patience: Patience,
        on_over: Callable[[], None],
        context: Context | None = None,
    ) -> None:
        """Make the node; see GoalClient."""
        super().__init__(
            f"{action.name}_action_client",
            action.type,
            action.name,
            goal,
            patience=patience,
            on_over=on_over,
            context=context,
        )

    def accepted_text(self) -> str:
        """In the tutorial's words."""
        return "Goal accepted..."

    def feedback_text(self, feedback: Any) -> str:
        """In the tutorial's words."""
        return f"Received feedback {LEGEND}: {feedback.current_battery_state.power_supply_status}"

    def result_text(self, result: Any) -> str:
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


def parse_arguments(action: BatteryAction, arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line without its ROS arguments; exits with 2 where it is wrong."""
    parser = client_parser(action.program, action.name)
    parser.add_argument("--voltage", type=_float32, default=2.16, metavar="V", help="desired voltage (default 2.16)")
    parser.add_argument(
        "--percentage", type=_float32, default=0.24, metavar="0…1", help="desired charge (default 0.24)"
    )
    parser.add_argument(
        "--status",
        type=_status,
        default=int(action.status),
        metavar="N",
        help=f"desired power_supply_status: {action.statuses}",
    )
    add_timeout(parser)
    return parser.parse_args(arguments)


def run_battery_client(action: BatteryAction, args: Sequence[str] | None) -> int:
    """Send a goal as the command line says and wait for its end.

    Args:
        action: The action.
        args: The command line, the program's name first; None is that of the process.

    Returns:
        The exit code, one of `docking.clients.session.ExitCode`.
    """
    command_line = list(sys.argv if args is None else args)
    options = parse_arguments(action, remove_ros_args(command_line)[1:])
    goal = action.type.Goal()
    goal.desired_battery_state.voltage = options.voltage
    goal.desired_battery_state.percentage = options.percentage
    goal.desired_battery_state.power_supply_status = options.status
    patience = Patience(server=options.timeout)
    return run_client(
        lambda context, on_over: BatteryClient(action, goal, patience=patience, on_over=on_over, context=context),
        command_line,
    )
