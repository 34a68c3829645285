"""The node `fibonacci_action_server` of the official action tutorial, with cancel."""

import sys
import time
from collections.abc import Sequence
from typing import Any

from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.task import Future

from action_tutorials_interfaces.action import Fibonacci as FibonacciAction
from docking.ros.given import given_to
from docking.ros.parameters import declare_parameters
from docking.ros.process import Spinner, StopSignals, ros_context, run_process
from docking.tutorial.fibonacci import Fibonacci, FibonacciSettings, check_order
from robot_io.rclpy_private import IdentifyingActionServer, goal_id_text

CLOSE_TIMEOUT = 1.0
LINGER = 0.2


class FibonacciServer(Node):  # type: ignore[misc] # rclpy has no types
    """Action server `fibonacci`: a number a step, any number of goals side by side.

    Everything here runs in the one thread that spins the node.
    """

    def __init__(self, *, context: Context | None = None, **options: Any) -> None:
        """Make the node.

        Args:
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
        """
        super().__init__("fibonacci_action_server", context=context, **options)
        self._closing = False
        self._pauses: dict[str, Future] = {}
        declare_parameters(self, FibonacciSettings, self._take_settings)
        self._server = IdentifyingActionServer(
            self,
            FibonacciAction,
            "fibonacci",
            execute_callback=self._execute,
            goal_callback=self._decide,
            cancel_callback=self._cancel,
        )

    def _take_settings(self, settings: FibonacciSettings) -> None:
        self._step_period = settings.step_period

    def _decide(self, request: FibonacciAction.Goal) -> GoalResponse:
        fault = "the action server is shutting down" if self._closing else check_order(request.order)
        if fault is None:
            return GoalResponse.ACCEPT
        self.get_logger().warning(f"Goal {self._server.deciding_on} rejected: {fault}")
        return GoalResponse.REJECT

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        self._end_pause(goal_id_text(handle.goal_id))
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle) -> FibonacciAction.Result:
        self.get_logger().info("Executing goal...")
        fibonacci = Fibonacci(handle.request.order)
        while not (fibonacci.complete or handle.is_cancel_requested or self._closing):
            fibonacci.step()
            self.get_logger().info(f"Feedback: {fibonacci.sequence}")
            handle.publish_feedback(FibonacciAction.Feedback(partial_sequence=fibonacci.sequence))
            await self._pause(goal_id_text(handle.goal_id))
        result = FibonacciAction.Result(sequence=fibonacci.sequence)
        if handle.is_cancel_requested:
            self.get_logger().info("Goal canceled")
            handle.canceled()
        elif fibonacci.complete:
            handle.succeed()
        else:
            self.get_logger().error("Goal aborted: the action server is shutting down")
            handle.abort()
        return result

    async def _pause(self, goal_id: str) -> None:
        """Wait for a step's time, for a cancel or for the end of the server."""
        self._pauses[goal_id] = Future()
        timer = self.create_timer(
            self._step_period, lambda: self._end_pause(goal_id), clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        await self._pauses[goal_id]
        del self._pauses[goal_id]
        self.destroy_timer(timer)

    def _end_pause(self, goal_id: str) -> None:
        pause = self._pauses.get(goal_id)
        if pause is not None:
            pause.set_result(None)

    def destroy_node(self) -> None:
        """Leave the ROS graph, with the action server, which rclpy would leave behind."""
        self._server.destroy()
        super().destroy_node()

    def close(self) -> None:
        """Let no more goals in and abort those that run; the node must be spun for another moment."""
        self._closing = True
        for goal_id in self._pauses:
            self._end_pause(goal_id)


def _run(args: Sequence[str] | None) -> int:
    signals = StopSignals()
    with ros_context(args) as context:
        server = FibonacciServer(context=context)
        given_to(context).warn([server])
        with Spinner(context, [server], on_failure=signals.wake) as spinner:
            signals.wait()
            spinner.call(server.close).result(CLOSE_TIMEOUT)
            time.sleep(LINGER)
        return 0 if spinner.failure is None else 1


def main(args: Sequence[str] | None = None) -> int:
    """Run the action server until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
