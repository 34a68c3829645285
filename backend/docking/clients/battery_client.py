"""The common part of the clients for docking and undocking: goal, feedback and result hold a battery state each."""

import argparse
import math
from typing import Any

from docking.clients.goal_client import GoalClient
from docking.core.battery import PowerSupplyStatus

LARGEST_FLOAT32 = 3.4028234663852886e38
LEGEND = "(1 = CHARGING, 3 = NOT CHARGING)"


class BatteryClient(GoalClient):
    """A client of such an action.

    Attributes:
        status: Desired status of a goal by default.
        statuses: Possible desired statuses, for the help text.
    """

    status: PowerSupplyStatus
    statuses: str

    @classmethod
    def add_options(cls, parser: argparse.ArgumentParser) -> None:
        """The desired battery state."""
        parser.add_argument(
            "--voltage", type=_float32, default=2.16, metavar="V", help="desired voltage (default 2.16)"
        )
        parser.add_argument(
            "--percentage", type=_float32, default=0.24, metavar="0…1", help="desired charge (default 0.24)"
        )
        parser.add_argument(
            "--status",
            type=_status,
            default=int(cls.status),
            metavar="N",
            help=f"desired power_supply_status: {cls.statuses}",
        )

    @classmethod
    def make_goal(cls, options: argparse.Namespace) -> Any:
        """A goal that asks for this state."""
        goal = cls.action_type.Goal()
        goal.desired_battery_state.voltage = options.voltage
        goal.desired_battery_state.percentage = options.percentage
        goal.desired_battery_state.power_supply_status = options.status
        return goal

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
