"""Takes messages of subscriptions and responses of services without rclpy's executor.

For each message the executor iterates over every entity of the node in Python: 0.2 ms with one action, 5 ms with a
hundred. Here a thread waits for entities of one kind only, rebuilds its wait set only when they change, and takes all
available messages before it waits again.
"""

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from enum import StrEnum
from typing import Any, Generic, TypeVar
from weakref import WeakKeyDictionary

from rclpy.client import Client
from rclpy.context import Context
from rclpy.guard_condition import GuardCondition
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from dock_gateway.ros.ros_thread import RosThread
from robot_io.rclpy_private import Buffer, Waiter, take_response

log = logging.getLogger(__name__)

# The maximum number of messages of one entity before the next entity's turn.
BURST = 100
# The maximum number of seconds of one entity's turn.
TURN = 0.005
# Seconds that a message takes to read, beyond which large messages are not read for a while.
SLOW = 0.005
# Bytes of a message beyond which it is a large one.
LARGE = 10_000
# The first bytes of a message, by which a callback decides whether it wants it.
HEAD = 32
# The number of requests per client that are remembered, to detect a second response.
REMEMBERED = 100
# That pause, as a multiple of the time that the message took.
REST = 20


E = TypeVar("E", Subscription, Client)


class Listener(ABC, Generic[E]):
    """Takes incoming messages for entities of one kind on its own thread.

    Args:
        name: Name of the thread.
        context: Context of the entities.
    """

    def __init__(self, name: str, context: Context) -> None:
        self._context = context
        self._wake = GuardCondition(None, None, context=context)
        self._lock = threading.Lock()
        self._entities: list[E] = []
        self._changed = True
        self._thread = RosThread(name, self._listen)

    @property
    def alive(self) -> bool:
        """Whether the thread is running."""
        return self._thread.alive

    def start(self) -> None:
        """Start listening."""
        self._thread.start()

    def close(self) -> bool:
        """Stop listening; return False if the thread does not end."""
        self._thread.stopping = True
        self._wake.trigger()
        return self._thread.end()

    def add(self, entity: E) -> None:
        """Listen to an entity."""
        with self._lock:
            self._entities.append(entity)
            self._changed = True
        self._wake.trigger()

    def remove(self, entity: E) -> bool:
        """Stop listening to an entity, which may then be destroyed at once; return False if it was not added."""
        with self._lock:
            if entity not in self._entities:
                return False
            self._entities.remove(entity)
            self._changed = True
        self._wake.trigger()
        return True

    def _listen(self) -> None:
        while not self._thread.stopping:
            with self._lock:
                wanted, self._changed = list(self._entities), False
            with Waiter(self._context, self._wake, wanted) as waiter:
                while not (self._changed or self._thread.stopping):
                    for entity in waiter.wait():
                        self._take_some(entity)

    def _take_some(self, entity: E) -> None:
        until = time.perf_counter() + TURN
        for _ in range(BURST):
            if not self._take(entity) or time.perf_counter() > until:
                return

    @abstractmethod
    def _take(self, entity: E) -> bool:
        """Take one message; return False if there is none."""


class Unread(StrEnum):
    """The reason why a message was not read: it is too large, or earlier ones took too long."""

    TOO_LARGE = "too_large"
    TOO_FAST = "too_fast"


class Handler:
    """A subscription's callback that a `MessageListener` calls. Its exceptions are logged and go no further.

    Args:
        callback: Called with each message and its info, as in `Buffer`.
        unread: Called with the bytes of each message that was not read, and the reason. It must not raise.
        wants: Returns whether to read a message, by its first bytes and its info. It must not raise.
        take: Takes and handles one message of a subscription in place of the listener, and returns whether there was
            one; None if the listener does.
    """

    def __init__(
        self,
        callback: Callable[[Any, Any], None],
        unread: Callable[[bytes, Unread], None] = lambda *_: None,
        wants: Callable[[bytes, dict[str, Any]], bool] = lambda *_: True,
        take: Callable[[Subscription], bool] | None = None,
    ) -> None:
        self.unread = unread
        self.wants = wants
        self.take = take
        self._callback = callback

    def __call__(self, message: Any, info: Any) -> None:
        """Handle a message."""
        try:
            self._callback(message, info)
        except Exception:
            log.exception("an error in a ROS callback")


class MessageListener(Listener[Subscription]):
    """Calls the handlers of subscriptions.

    Messages are taken as bytes, so that oversized ones are never deserialized. A topic whose messages are slow to read
    is throttled, to leave time for others.

    Args:
        name: Name of the thread.
        context: Context of the entities.
        max_bytes: The largest message that is read, in bytes.
    """

    def __init__(self, name: str, context: Context, max_bytes: int) -> None:
        super().__init__(name, context)
        self._max_bytes = max_bytes
        self._buffer = Buffer()
        self._rests_until: WeakKeyDictionary[Subscription, float] = WeakKeyDictionary()

    def _take(self, entity: Subscription) -> bool:
        handler: Handler = entity.callback
        if handler.take is not None:
            return handler.take(entity)
        buffer = self._buffer
        if not buffer.take(entity):
            return False
        info = buffer.info
        if not handler.wants(buffer.read(HEAD), info):
            return True
        if entity.raw:
            handler(buffer.read(), info)
        elif (why := self._refuse(entity, buffer.size)) is not None:
            log.warning("a message of %d bytes on %s is not read: %s", buffer.size, entity.topic_name, why)
            handler.unread(buffer.read(), why)
        else:
            self._read(entity, buffer.read(), info)
        return True

    def _refuse(self, entity: Subscription, size: int) -> Unread | None:
        if size > self._max_bytes:
            return Unread.TOO_LARGE
        if size > LARGE and time.monotonic() < self._rests_until.get(entity, 0.0):
            return Unread.TOO_FAST
        return None

    def _read(self, entity: Subscription, data: bytes, info: dict[str, Any]) -> None:
        began = time.thread_time()
        try:
            message = deserialize_message(data, entity.msg_type)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            log.warning("a message on %s cannot be read: %s", entity.topic_name, error)
            return
        entity.callback(message, info)
        if (took := time.thread_time() - began) > SLOW:
            self._rests_until[entity] = time.monotonic() + REST * took


class AnswerListener(Listener[Client]):
    """Resolves the futures of a client's `call_async`. Their callbacks must not raise.

    A request reaches every server of the service; the first response counts.

    Args:
        name: Name of the thread.
        context: Context of the entities.
    """

    def __init__(self, name: str, context: Context) -> None:
        super().__init__(name, context)
        self._answered: WeakKeyDictionary[Client, deque[int]] = WeakKeyDictionary()
        self._twice: WeakKeyDictionary[Client, float] = WeakKeyDictionary()

    def answered_twice_at(self, client: Client) -> float:
        """Return when a request of a client last got a second response, on the monotonic clock."""
        return self._twice.get(client, float("-inf"))

    def _take(self, entity: Client) -> bool:
        taken = take_response(entity)
        if taken is None:
            return False
        number, response = taken
        answered = self._answered.setdefault(entity, deque(maxlen=REMEMBERED))
        if number in answered:
            self._twice[entity] = time.monotonic()
            return True
        answered.append(number)
        with suppress(KeyError):  # no longer awaited
            entity.get_pending_request(number).set_result(response)
        return True
