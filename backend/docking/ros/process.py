"""A ROS process: nodes spun in a thread of their own, signals awaited in the main thread.

All that touches nodes runs in the spinning thread, which spares the nodes every lock.
"""

import contextlib
import os
import signal
import socket
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from types import TracebackType
from typing import Self, TypeVar

from rclpy.context import Context
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from docking.ros.given import read_arguments
from robot_io.participants import create_context
from robot_io.rclpy_private import (
    RCLError,
    RCLInvalidROSArgsError,
    UnknownROSArgsError,
    UnsupportedRclpyError,
    reason,
)
from robot_io.services import always_answer

T = TypeVar("T")

JOIN_TIMEOUT = 0.5
EXIT_USAGE = 2
"""Exit code: the command line, a parameter or what ROS needs is wrong."""


class StopSignals:
    """The signals that end a process; a wait for one also ends when `wake` is called.

    The kernel may hand a signal to any thread, as it does after SIGSTOP. That does not wake a main thread that waits
    for a lock or an event, and Python runs signal handlers in the main thread alone. So the main thread reads from a
    socket, to which Python writes the number of each signal in whichever thread it comes.

    The handlers stay until the process is gone, so that a second signal cannot cut its ending short. SIGHUP, the end of
    the terminal, stays ignored where it was (`nohup`).
    """

    def __init__(self) -> None:
        self._receiver, self._sender = socket.socketpair()
        self._sender.setblocking(False)
        signal.set_wakeup_fd(self._sender.fileno(), warn_on_full_buffer=False)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._handle)

    def _handle(self, _number: int, _frame: object) -> None:
        """Nothing is left to do, but Python writes the numbers of those signals only that have a handler."""

    def wake(self) -> None:
        """End a wait, from any thread."""
        with contextlib.suppress(BlockingIOError):  # the buffer is full, which ends a wait, too
            self._sender.send(b"\0")

    def wait(self) -> int:
        """Wait for a signal or for `wake`.

        Returns:
            How many signals came since the last call.
        """
        return sum(number != 0 for number in self._receiver.recv(4096))


@contextlib.contextmanager
def ros_context(args: Sequence[str] | None = None, *, domain_id: int | None = None) -> Iterator[Context]:
    """A ROS context without signal handlers of its own, for as long as it is held.

    Args:
        args: The command line with its `--ros-args`; None is that of the process.
        domain_id: None is the ROS_DOMAIN_ID of the environment.

    Raises:
        ValueError: The ROS arguments are wrong, or this rclpy is not supported.
        RCLError: ROS does not start, such as with a parameter file that cannot be read.
    """
    try:
        context = create_context(args, domain_id=domain_id)
    except UnsupportedRclpyError as error:
        raise ValueError(str(error)) from error
    except (UnknownROSArgsError, RCLInvalidROSArgsError) as error:
        raise ValueError(f"wrong ROS arguments: {error}") from error
    read_arguments(context, args)
    try:
        yield context
    finally:
        context.try_shutdown()


class Spinner:
    """Spins nodes in a thread of its own, and destroys them on the way out.

    Attributes:
        failure: The exception that ended the thread, if one did.
    """

    def __init__(self, context: Context, nodes: Sequence[Node], on_failure: Callable[[], None] | None = None) -> None:
        """Take over the nodes.

        Args:
            context: The context of the nodes.
            nodes: The nodes to spin; from now on they belong to the spinner's thread.
            on_failure: Called in that thread when an exception has ended it.
        """
        self.failure: BaseException | None = None
        self._context = context
        self._nodes = nodes
        self._on_failure = on_failure
        self._stopping = False
        self._executor = SingleThreadedExecutor(context=context)
        for node in nodes:
            always_answer(node, node.get_logger().error)
            self._executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name="ros", daemon=True)

    def _spin(self) -> None:
        try:
            while not self._stopping and self._context.ok():
                self._executor.spin_once()
        except BaseException as error:  # noqa: BLE001 - whatever it is, the process must learn of it and end
            self.failure = error
            traceback.print_exc()
            if self._on_failure is not None:
                self._on_failure()

    def call(self, function: Callable[[], T]) -> "Future[T]":
        """Run a function in the spinner's thread, or in the caller's when that thread has failed.

        Returns:
            A future that any thread may wait for; it holds what the function raised.
        """
        future: Future[T] = Future()

        def run() -> None:
            try:
                future.set_result(function())
            except Exception as error:  # noqa: BLE001 - it is raised where the future is read
                future.set_exception(error)

        if self.failure is None and self._thread.is_alive():
            self._executor.create_task(run)
        else:
            run()
        return future

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stopping = True
        self._executor.create_task(lambda: None)  # `wake` alone leaves it waiting inside `spin_once`
        self._thread.join(JOIN_TIMEOUT)
        if self._thread.is_alive():
            print("error: a callback hangs", file=sys.stderr, flush=True)  # noqa: T201 - its node cannot be used
            os._exit(1)  # any other way out waits for the callback, or ends in a crash inside rclpy
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()


def run_process(body: Callable[[Sequence[str] | None], int], args: Sequence[str] | None) -> int:
    """Run the body of a `main`; report a wrong command line or parameter, or ROS that does not start, in one line.

    Returns:
        The exit code.
    """
    try:
        return body(args)
    except (ParameterException, ValueError) as error:
        why = str(error)
    except RCLError as error:
        why = f"ROS does not start: {reason(error)}"
    print(f"error: {why}", file=sys.stderr)  # noqa: T201 - there may be no node to log with
    return EXIT_USAGE
