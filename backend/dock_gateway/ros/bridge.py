"""The only place where ROS's threads and the asyncio loop meet: one crossing each way.

rclpy's clients, publishers and subscriptions are created and destroyed on the ROS thread only. Requests are sent from
the loop, which is cheaper than waking another thread. Messages and responses arrive on the listeners' threads, which
call the loop only through `call_soon_threadsafe`. The other modules need not know about the threads.
"""

import asyncio
import logging
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future as RosFuture

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.own_topics import OwnTopics
from dock_gateway.ros.inbox import Inbox, Inboxes
from dock_gateway.ros.listener import AnswerListener, MessageListener
from dock_gateway.ros.listening_node import ListeningNode
from dock_gateway.ros.ros_thread import RosThread
from robot_io.participants import create_context
from robot_io.rclpy_private import InvalidHandle, RCLError, reason
from robot_io.services import always_answer

log = logging.getLogger(__name__)

T = TypeVar("T")

# The maximum number of branches, each with about ten threads.
MAX_BRANCHES = 4
# Seconds after which a thread that computes lets another one run. A stop waits for the loop some ten times; with
# Python's default of 5 ms, each time for so long while a listener is busy.
SWITCH_INTERVAL = 0.001
# Fast DDS drops a message that it cannot send at once. If it waited, as it does otherwise, it would block every thread
# for seconds while robots are unreachable. Reliable messages are sent again. Not needed, and not used, with LOCALHOST.
TRANSPORTS = "DEFAULT?non_blocking=true"


class PendingCall:
    """A service request that was sent; `response` is resolved on the loop when the answer arrives.

    Args:
        bridge: The bridge to the loop.
        client: The client of the service.
        request: The request to send.
        response: The future to resolve.
        read: Converts the answer, on the listener's thread.

    Raises:
        InvalidHandle: The client was destroyed.
    """

    def __init__(
        self,
        bridge: "Bridge",
        client: Client,
        request: Any,
        response: "asyncio.Future[Any]",
        read: Callable[[Any], Any],
    ) -> None:
        self.response = response
        self._read = read
        self._bridge = bridge
        self._client = client
        self._ros_future: RosFuture = client.call_async(request)
        self._ros_future.add_done_callback(self._answered)

    def _answered(self, ros_future: RosFuture) -> None:
        try:
            answer = self._read(ros_future.result())
        except Exception as error:  # noqa: BLE001 - it is raised again where the answer is awaited
            self._bridge.to_loop(_settle, self.response, None, error)
        else:
            self._bridge.to_loop(_settle, self.response, answer, None)

    def forget(self) -> None:
        """Stop waiting; a later answer is dropped."""
        self.response.cancel()
        self._client.remove_pending_request(self._ros_future)

    def fail(self, error: Exception) -> None:
        """Raise an error where the answer is awaited; a later answer is dropped."""
        _settle(self.response, None, error)
        self._client.remove_pending_request(self._ros_future)


@contextmanager
def starting() -> Iterator[None]:
    """A context and a node are made within.

    Raises:
        Unavailable: ROS does not start (`ros_unavailable`).
    """
    try:
        yield
    except RCLError as error:
        raise Unavailable(f"ROS does not start: {reason(error)}", code="ros_unavailable") from error


class Bridge:
    """An rclpy context, node and executor, spun in their own thread, and the listeners of the node.

    Args:
        node_name: Name of the node.
        namespace: Namespace of the node.
        max_message_bytes: The largest message that is read, in bytes.
        loop: The event loop, if this is a branch of another bridge.
        own_topics: The topics whose type follows from their name.

    Raises:
        Unavailable: ROS does not start (`ros_unavailable`).

    Attributes:
        joined_at: When it joined the ROS graph, on the monotonic clock.
        branches: Its branches, oldest first.
        users: The number of users of this branch.
    """

    def __init__(
        self,
        node_name: str,
        namespace: str,
        max_message_bytes: int,
        loop: asyncio.AbstractEventLoop | None = None,
        own_topics: OwnTopics | None = None,
    ) -> None:
        self._loop = loop or asyncio.get_running_loop()
        self.joined_at = time.monotonic()
        self.branches: list[Bridge] = []
        self.users = 0
        self._names = node_name, namespace
        self._own_topics = own_topics
        self._joining = asyncio.Lock()
        self._closing = threading.Lock()
        self._closed = False
        os.environ.setdefault("FASTDDS_BUILTIN_TRANSPORTS", TRANSPORTS)
        # A second node of the same name must not register services and topics that the first one has.
        own = {} if loop is None else {"enable_rosout": False, "start_parameter_services": False}
        with starting():
            self._context = create_context()
            self._messages = MessageListener("ros-messages", self._context, max_message_bytes)
            self._answers = AnswerListener("ros-answers", self._context)
            self.node = ListeningNode(
                node_name,
                namespace or None,
                self._context,
                self._messages,
                self._answers,
                own_topics=own_topics,
                **own,
            )
        always_answer(self.node, log.exception)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = RosThread("ros", self._executor.spin)
        self._waiting: deque[Callable[[], object]] = deque()
        self._adding = threading.Lock()  # guards the end of the executor, which takes no task afterwards
        self._inboxes = Inboxes(self.to_loop)
        self.max_message_bytes = max_message_bytes

    @property
    def alive(self) -> bool:
        """Whether all ROS threads are running."""
        return self._thread.alive and self._messages.alive and self._answers.alive

    def start(self) -> None:
        """Start spinning. Publishers, clients and subscriptions are best created before."""
        sys.setswitchinterval(SWITCH_INTERVAL)
        for thread in (self._thread, self._messages, self._answers):
            thread.start()

    def close(self) -> None:
        """Stop spinning and leave the ROS graph; blocks until the threads end, or a few seconds."""
        closing = [branch.close_soon() for branch in self.branches]
        with self._closing:
            if not self._closed:
                self._closed = True
                self._leave()
        for thread in closing:
            thread.join(1.0)

    def _leave(self) -> None:
        with self._adding:
            self._thread.stopping = True
        self._executor.shutdown(timeout_sec=0.5)
        ended = [self._messages.close(), self._answers.close(), self._thread.end()]
        if not all(ended):
            return
        self.node.destroy_node()
        self._context.try_shutdown()

    # ------------------------------------------------------------------ branches

    async def branch(self, after: float) -> "Bridge":
        """Return a DDS participant that no peer has met before a time. `release` it after use.

        It is shared by all callers, and closed with this bridge. If there are `MAX_BRANCHES`, the newest is returned.

        Args:
            after: The time, on the monotonic clock.
        """
        async with self._joining:
            newest = self.branches[-1] if self.branches else None
            if newest is None or (newest.joined_at <= after and len(self.branches) < MAX_BRANCHES):
                newest = await self._make_branch()
            newest.users += 1
            return newest

    async def _make_branch(self) -> "Bridge":
        def make() -> Bridge:
            branch = Bridge(*self._names, self.max_message_bytes, self._loop, self._own_topics)
            branch.start()
            return branch

        making = self._loop.run_in_executor(None, make)
        try:
            branch = await asyncio.shield(making)
        except asyncio.CancelledError:
            making.add_done_callback(lambda made: made.result().close_soon())
            raise
        self.branches.append(branch)
        return branch

    def release(self, branch: "Bridge") -> None:
        """Close a branch when its last user has released it; do nothing for any other bridge."""
        branch.users -= 1
        if branch in self.branches and branch.users == 0:
            self.branches.remove(branch)
            branch.close_soon()

    def close_soon(self) -> threading.Thread:
        """Close it in a thread, which is returned."""
        thread = threading.Thread(target=self.close, name="leaving ROS", daemon=True)
        thread.start()
        return thread

    # ------------------------------------------------------------------ calls

    def to_ros(self, function: Callable[[], object]) -> None:
        """Schedule a function on the ROS thread, in the order of the calls; its exceptions are logged.

        Does nothing once the bridge closes, as all that the node has is destroyed with it.
        """
        with self._adding:
            if self._thread.stopping:
                return
            self._waiting.append(function)
            self._executor.create_task(self._run_next)

    def _run_next(self) -> None:
        """Run the oldest pending call, because the executor takes its newest task first."""
        try:
            self._waiting.popleft()()
        except Exception:  # must not reach the executor: it would end its thread
            log.exception("an error on the ROS thread")

    def to_loop(self, function: Callable[..., object], *args: object) -> None:
        """Schedule a function on the loop, from the ROS thread. Does nothing once the loop is closed."""
        try:
            self._loop.call_soon_threadsafe(function, *args)
        except RuntimeError:
            if not self._loop.is_closed():
                raise

    def inbox(self, on_drop: Callable[..., object] = lambda *_: None) -> Inbox:
        """Create an inbox, which passes a subscription's messages to the loop.

        Args:
            on_drop: Called on the listener's thread with the arguments of each dropped message.
        """
        return Inbox(self._inboxes, on_drop)

    async def call(
        self,
        function: Callable[[], T],
        timeout: float = 2.0,
        *,
        undo: Callable[[T], object] | None = None,
        even_late: bool = False,
    ) -> T:
        """Run a function on the ROS thread and return its result.

        If the function has not started after the timeout, it never runs. If it has, it gets the same time again.

        Args:
            function: The function to run.
            timeout: Seconds until the caller gives up.
            undo: Called on the ROS thread with the function's result if the caller has already gone.
            even_late: Run it even after the caller has given up, as for a stop.

        Raises:
            Unavailable: The ROS thread is down or too slow (`ros_unavailable`).
        """
        self._require_alive()
        done: asyncio.Future[T] = self._loop.create_future()
        decided = threading.Lock()  # taken by the ROS thread to run it, or by the caller to give up

        def settle(result: T) -> None:
            if not done.done():
                done.set_result(result)
            elif undo is not None:
                self.to_ros(lambda: undo(result))

        def run() -> None:
            if not decided.acquire(blocking=False) and not even_late:
                return
            try:
                result = function()
            except Exception as error:  # noqa: BLE001 - it is raised again where it was asked for
                self.to_loop(_settle, done, None, error)
            else:
                self.to_loop(settle, result)

        self.to_ros(run)
        try:
            await asyncio.wait((done,), timeout=timeout)
            if not done.done() and not decided.acquire(blocking=False):
                await asyncio.wait((done,), timeout=timeout)
            if not done.done():
                raise Unavailable("the ROS thread does not answer", code="ros_unavailable")
            return done.result()
        finally:
            decided.acquire(blocking=False)
            done.cancel()

    def request(self, client: Client, request: Any, read: Callable[[Any], Any] = lambda answer: answer) -> PendingCall:
        """Send a service request; `read` converts the answer on the listener's thread.

        Raises:
            Unavailable: It has no server, or the ROS thread is down (`ros_unavailable`).
        """
        self._require_alive()
        try:
            if not client.service_is_ready():
                raise Unavailable(f"there is no server for {client.service_name}")
            return PendingCall(self, client, request, self._loop.create_future(), read)
        except InvalidHandle:
            raise Unavailable("the action has left the ROS graph") from None

    def _require_alive(self) -> None:
        if not self.alive:
            raise Unavailable("the ROS thread is down; restart the gateway", code="ros_unavailable")


def _settle(future: "asyncio.Future[T]", result: T, error: BaseException | None) -> None:
    if future.done():  # no longer awaited
        return
    if error is not None:
        future.set_exception(error)
    else:
        future.set_result(result)


def ros_environment() -> dict[str, str]:
    """Return the environment variables that affect discovery, for logs and /healthz."""
    names = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "RMW_IMPLEMENTATION")
    return {name: os.environ[name] for name in names if name in os.environ}
