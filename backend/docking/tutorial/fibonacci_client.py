"""The node `fibonacci_action_client` of the official action tutorial, with cancel."""

import argparse
import sys
from collections.abc import Callable, Sequence

from rclpy.context import Context
from rclpy.utilities import remove_ros_args

from action_tutorials_interfaces.action import Fibonacci as FibonacciAction
from docking.clients.goal_client import GoalClient, add_timeout, client_parser, run_client
from docking.clients.session import Patience
from docking.ros.process import run_process


class FibonacciClient(GoalClient):
    """A client of `fibonacci`."""

    def __init__(
        self,
        goal: FibonacciAction.Goal,
        *,
        patience: Patience,
        on_over: Callable[[], None],
        context: Context | None = None,
    ) -> None:
        """Make the node; see GoalClient."""
        super().__init__(
            "fibonacci_action_client",
            FibonacciAction,
            "fibonacci",
            goal,
            patience=patience,
            on_over=on_over,
            context=context,
        )

    def accepted_text(self) -> str:
        """In the tutorial's words."""
        return "Goal accepted :)"

    def feedback_text(self, feedback: FibonacciAction.Feedback) -> str:
        """In the tutorial's words."""
        return f"Received feedback: {list(feedback.partial_sequence)}"

    def result_text(self, result: FibonacciAction.Result) -> str:
        """In the tutorial's words."""
        return f"Result: {list(result.sequence)}"


def _int32(text: str) -> int:
    value = int(text)
    if not -(2**31) <= value < 2**31:
        raise argparse.ArgumentTypeError(f"{text} is not an int32")
    return value


def parse_arguments(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line without its ROS arguments; exits with 2 where it is wrong."""
    parser = client_parser("fibonacci_action_client", "fibonacci")
    parser.add_argument("--order", type=_int32, default=10, metavar="N", help="how far to count (default 10)")
    add_timeout(parser)
    return parser.parse_args(arguments)


def _run(args: Sequence[str] | None) -> int:
    command_line = list(sys.argv if args is None else args)
    options = parse_arguments(remove_ros_args(command_line)[1:])
    goal = FibonacciAction.Goal(order=options.order)
    patience = Patience(server=options.timeout)
    return run_client(
        lambda context, on_over: FibonacciClient(goal, patience=patience, on_over=on_over, context=context),
        command_line,
    )


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end.

    Args:
        args: The command line, the program's name first; None is that of the process.

    Returns:
        The exit code, one of `docking.clients.session.ExitCode` or 2.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
