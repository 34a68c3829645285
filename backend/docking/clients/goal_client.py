"""A node that sends one goal, tells what becomes of it, and never hangs."""

import argparse
import sys
import time
import uuid
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from action_msgs.srv import CancelGoal
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.task import Future
from rclpy.timer import Timer
from rclpy.utilities import remove_ros_args
from unique_identifier_msgs.msg import UUID

from docking.clients.session import ExitCode, Patience, Phase, Request, Session
from docking.ros.given import given_to
from docking.ros.process import Spinner, StopSignals, ros_context, run_process
from robot_io.rclpy_private import goal_id_text

STEP_PERIOD = 0.05
LINGER = 0.2
EXPLANATION_PATIENCE = 2.5
"""How long to wait for the reason of a failure, in seconds: a server repeats it on /diagnostics each second."""
EXPLAINED = frozenset({ExitCode.REJECTED, ExitCode.ABORTED})


def _random_uuid() -> UUID:
    return UUID(uuid=list(uuid.uuid4().bytes))


class GoalClient(Node):  # type: ignore[misc] # rclpy has no types
    """Sends a goal when a server answers, and ends its session with an exit code.

    A server is asked for a sign of life by canceling a goal that does not exist: every action server answers that, and
    it changes nothing. It also proves that the server has found this client, before which an answer to the goal would
    get lost. A subclass has the goal and the words of its action.

    Attributes:
        program: The client's name on the command line.
        action_type: The generated class of the action.
        action_name: Relative, so that it can be remapped.
    """

    program: str
    action_type: Any
    action_name: str

    def __init__(
        self, goal: Any, *, patience: Patience, on_over: Callable[[], None], context: Context | None = None
    ) -> None:
        """Make the node; it starts to work when it is spun.

        Args:
            goal: The goal message.
            patience: The deadlines.
            on_over: Called once, in the thread that spins the node, when there is an exit code.
            context: The ROS context; None is the default one.
        """
        super().__init__(f"{self.action_name}_action_client", context=context)
        self._goal = goal
        self._goal_id = _random_uuid()
        self._handle: ClientGoalHandle | None = None
        self._early_feedback: list[Any] = []
        self._reason = ""
        self._on_over = on_over
        self._client = ActionClient(self, self.action_type, self.action_name)
        self._cancel_client = self.create_client(CancelGoal, f"{self.action_name}/_action/cancel_goal")
        self._subscription = self.create_subscription(DiagnosticArray, "/diagnostics", self._note_reason, 10)
        self._session = Session(patience, time.monotonic())
        self._told = False
        self._waiting: Timer | None = None
        self._timer = self.create_timer(STEP_PERIOD, self._step, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def exit_code(self) -> ExitCode | None:
        """The exit code of the goal's end; None before."""
        return self._session.exit_code

    @classmethod
    @abstractmethod
    def add_options(cls, parser: argparse.ArgumentParser) -> None:
        """Add what the command line can say of the goal."""

    @classmethod
    @abstractmethod
    def make_goal(cls, options: argparse.Namespace) -> Any:
        """The goal message, as the command line says."""

    @abstractmethod
    def accepted_text(self) -> str:
        """Return the log line for an accepted goal."""

    @abstractmethod
    def feedback_text(self, feedback: Any) -> str:
        """Return the log line for a feedback message."""

    @abstractmethod
    def result_text(self, result: Any) -> str:
        """Return the log line for a result."""

    def interrupt(self) -> None:
        """Cancel the goal, or leave if that was asked for before."""
        self._session.interrupt()
        if self._session.phase is Phase.RUNNING:
            self.get_logger().info("Canceling the goal...")
        self._step()

    def _step(self) -> None:
        request = self._session.step(time.monotonic())
        if request is Request.PING:
            self._ping()
        elif request is Request.SEND_GOAL:
            future = self._client.send_goal_async(self._goal, self._feed_back, goal_uuid=self._goal_id)
            future.add_done_callback(self._take_answer)
        elif request is Request.CANCEL_GOAL:
            self._call_cancel(self._goal_id, self._take_cancel_answer)
        self._end_if_over()

    def _ping(self) -> None:
        if self._cancel_client.service_is_ready():
            self._call_cancel(_random_uuid(), lambda _future: self._session.heard(time.monotonic()))
        if self._handle is not None:  # a server that was restarted answers this at once
            self._handle.get_result_async().add_done_callback(self._take_result)

    def _call_cancel(self, goal_id: UUID, answered: Callable[[Future], None]) -> None:
        request = CancelGoal.Request()
        request.goal_info.goal_id = goal_id
        self._cancel_client.call_async(request).add_done_callback(answered)

    def _take_answer(self, future: Future) -> None:
        handle: ClientGoalHandle = future.result()
        if self._session.phase is not Phase.SENT:
            return
        self._session.answered(accepted=handle.accepted, now=time.monotonic())
        if handle.accepted:
            self.get_logger().info(self.accepted_text())
            self._handle = handle
            for message in self._early_feedback:
                self._feed_back(message)
            handle.get_result_async().add_done_callback(self._take_result)
        self._end_if_over()

    def _feed_back(self, message: Any) -> None:
        self._session.heard(time.monotonic())
        if self._session.phase is Phase.SENT:
            self._early_feedback.append(message)  # feedback can overtake the acceptance
        elif self._session.phase is Phase.RUNNING:
            self.get_logger().info(self.feedback_text(message.feedback))

    def _take_result(self, future: Future) -> None:
        if self._session.phase is not Phase.RUNNING:
            return
        response = future.result()
        self._session.ended(response.status)
        if self._session.exit_code is not ExitCode.LOST:
            self.get_logger().info(self.result_text(response.result))
        self._end_if_over()

    def _take_cancel_answer(self, future: Future) -> None:
        if self._session.phase is Phase.RUNNING and not future.result().goals_canceling:
            self.get_logger().warning("The action server refused to cancel the goal; press Ctrl-C again to exit")
            self._session.cancel_refused()

    def _note_reason(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            if values.get("goal_id") == goal_id_text(self._goal_id):
                self._reason = values.get("error_msg", "")
        if self._reason:
            self._end_if_over()

    def _end_if_over(self) -> None:
        if self._session.exit_code is None or self._told:
            return
        self._timer.cancel()
        if self._session.exit_code not in EXPLAINED or self._reason:
            self._tell()
        elif self._waiting is None:
            # The reason travels on another topic, whose publisher may be found later than the server.
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self._waiting = self.create_timer(EXPLANATION_PATIENCE, self._tell, clock=steady)

    def _tell(self) -> None:
        self._told = True
        if self._waiting is not None:
            self._waiting.cancel()
        text = self._session.explanation.capitalize()
        if self._session.exit_code in EXPLAINED:
            self.get_logger().error(f"{text}: {self._reason or 'the log of the action server says why'}")
        elif self._session.exit_code in {ExitCode.CANCELED, ExitCode.INTERRUPTED}:
            self.get_logger().warning(text)
        elif self._session.exit_code is not ExitCode.SUCCEEDED:
            self.get_logger().error(text)
        self._on_over()


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 < value <= 86400.0:
        raise argparse.ArgumentTypeError(f"{text} is not between 0 and 86400 seconds")
    return value


def parse_arguments(client: type[GoalClient], arguments: Sequence[str]) -> argparse.Namespace:
    """Parse a client's command line without its ROS arguments; exits with 2 where it is wrong."""
    parser = argparse.ArgumentParser(
        prog=client.program,
        description=f"Send a goal to the action server {client.action_name} and print its feedback and result.",
        epilog="Exit codes: 0 succeeded, 1 aborted, 2 usage, 3 rejected, 4 canceled, 5 no server, 6 server lost,"
        " 130 interrupted. Ctrl-C cancels the goal.",
    )
    client.add_options(parser)
    parser.add_argument(
        "--timeout",
        type=_seconds,
        default=10.0,
        metavar="S",
        help="time to wait for a server, and for its answer to the goal (default 10 s)",
    )
    return parser.parse_args(arguments)


def run_client(client: type[GoalClient], args: Sequence[str] | None) -> int:
    """Send a goal as the command line says, and wait for its end.

    Args:
        client: The client.
        args: The command line, the program's name first; None is that of the process.

    Returns:
        The exit code, one of `ExitCode`, or 2 where the command line is wrong.
    """
    return run_process(partial(_run, client), args)


def _run(client: type[GoalClient], args: Sequence[str] | None) -> int:
    args = list(sys.argv if args is None else args)
    options = parse_arguments(client, remove_ros_args(args)[1:])
    goal, patience = client.make_goal(options), Patience(server=options.timeout, acceptance=options.timeout)
    signals = StopSignals()
    with ros_context(args) as context:
        node = client(goal, patience=patience, on_over=signals.wake, context=context)
        given_to(context).warn([node])
        with Spinner(context, [node], on_failure=signals.wake) as spinner:
            while node.exit_code is None and spinner.failure is None:
                for _ in range(signals.wait()):
                    spinner.call(node.interrupt)
            time.sleep(LINGER)  # for a last request and the log to go out
        return 1 if node.exit_code is None else int(node.exit_code)
