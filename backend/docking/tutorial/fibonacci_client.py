"""The node `fibonacci_action_client` of the official action tutorial, with cancel."""

import argparse
import sys
from collections.abc import Sequence

from action_tutorials_interfaces.action import Fibonacci
from docking.clients.goal_client import GoalClient, run_client


class FibonacciClient(GoalClient):
    """A client of `fibonacci`."""

    program = "fibonacci_action_client"
    action_type = Fibonacci
    action_name = "fibonacci"

    @classmethod
    def add_options(cls, parser: argparse.ArgumentParser) -> None:
        """Add the option that says how far to count."""
        parser.add_argument("--order", type=_int32, default=10, metavar="N", help="how far to count (default 10)")

    @classmethod
    def make_goal(cls, options: argparse.Namespace) -> Fibonacci.Goal:
        """A goal that counts so far."""
        return Fibonacci.Goal(order=options.order)

    def accepted_text(self) -> str:
        """In the tutorial's words."""
        return "Goal accepted :)"

    def feedback_text(self, feedback: Fibonacci.Feedback) -> str:
        """In the tutorial's words."""
        return f"Received feedback: {list(feedback.partial_sequence)}"

    def result_text(self, result: Fibonacci.Result) -> str:
        """In the tutorial's words."""
        return f"Result: {list(result.sequence)}"


def _int32(text: str) -> int:
    value = int(text)
    if not -(2**31) <= value < 2**31:
        raise argparse.ArgumentTypeError(f"{text} is not an int32")
    return value


def main(args: Sequence[str] | None = None) -> int:
    """Send a goal and wait for its end; see `run_client`."""
    return run_client(FibonacciClient, args)


if __name__ == "__main__":
    sys.exit(main())
