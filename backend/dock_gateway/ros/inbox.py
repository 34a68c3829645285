"""Bounded queues from ROS's threads to the loop, one per source, served round-robin in short time slices.

`call_soon_threadsafe` is unbounded. A node that sends faster than the loop can process would fill the memory, and the
loop would do nothing else until it had caught up.
"""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

log = logging.getLogger(__name__)

# The maximum number of queued messages, and of bytes, per source.
MAX_MESSAGES = 1000
MAX_BYTES = 4_000_000
# Seconds that the loop processes messages before it does other work.
PORTION = 0.002


class InboxCall(NamedTuple):
    """A call for the loop; `size` is in bytes if it may be dropped, else None."""

    function: Callable[..., object]
    args: tuple[Any, ...]
    size: int | None


class Inbox:
    """The messages of one source, in order.

    Args:
        inboxes: The inboxes that this one belongs to.
        on_drop: Called with the arguments of each dropped message, on the thread that added another.
        max_messages: The maximum number of queued messages. Their size is limited to `MAX_BYTES`.
        wait_for_room: Seconds that a thread waits for room if nothing may be dropped.
    """

    def __init__(
        self,
        inboxes: "Inboxes",
        on_drop: Callable[..., object],
        *,
        max_messages: int = MAX_MESSAGES,
        wait_for_room: float = 0.1,
    ) -> None:
        self._inboxes = inboxes
        self._on_drop = on_drop
        self._max_messages = max_messages
        self._wait_for_room = wait_for_room
        self._messages: deque[InboxCall] = deque()
        self._size = 0

    def put(self, function: Callable[..., object], *args: object) -> None:
        """Call a function on the loop. If the inbox is full, wait a moment for room: DDS keeps later messages."""
        with self._inboxes.changed:
            self._inboxes.changed.wait_for(lambda: len(self._messages) < self._max_messages, self._wait_for_room)
            self._append(InboxCall(function, args, None))

    def offer(self, size: int, function: Callable[..., object], *args: object) -> None:
        """Call a function on the loop; if the inbox is full, drop the oldest calls.

        Args:
            size: Size of the arguments in bytes.
            function: The function to call.
            args: Its arguments.
        """
        dropped: list[InboxCall] = []
        with self._inboxes.changed:
            self._append(InboxCall(function, args, size))
            while self._is_over_full() and (found := self._drop_oldest()):
                dropped.append(found)
        for message in dropped:
            self._on_drop(*message.args)

    def _is_over_full(self) -> bool:
        return len(self._messages) > self._max_messages or self._size > MAX_BYTES

    def _append(self, message: InboxCall) -> None:
        self._messages.append(message)
        self._size += message.size or 0
        if len(self._messages) == 1:
            self._inboxes.announce(self)

    def _drop_oldest(self) -> InboxCall | None:
        for index, message in enumerate(self._messages):
            if message.size is not None and index + 1 < len(self._messages):  # the newest stays
                del self._messages[index]
                self._size -= message.size
                return message
        return None

    def take(self) -> tuple[InboxCall, bool]:
        """Remove and return the oldest message, and whether there are more."""
        message = self._messages.popleft()
        self._size -= message.size or 0
        return message, bool(self._messages)


class Inboxes:
    """Makes the queued calls on the loop, one message of each inbox in turn.

    Args:
        call: Schedules a function on the loop; thread-safe.

    Attributes:
        changed: Guards all inboxes; notified when there is room again.
    """

    def __init__(self, call: Callable[[Callable[[], object]], object]) -> None:
        self.changed = threading.Condition()
        self._call = call
        self._ready: deque[Inbox] = deque()
        self._called = False

    def announce(self, inbox: Inbox) -> None:
        """Queue an inbox that is no longer empty; the caller holds the lock."""
        self._ready.append(inbox)
        if not self._called:
            self._called = True
            self._call(self._serve)

    def _serve(self) -> None:
        until = time.perf_counter() + PORTION
        while (message := self._next()) is not None:
            try:
                message.function(*message.args)
            except Exception:
                log.exception("an error while handling a ROS message")
            if time.perf_counter() > until:
                asyncio.get_running_loop().call_soon(self._serve)
                return

    def _next(self) -> InboxCall | None:
        with self.changed:
            if not self._ready:
                self._called = False
                return None
            inbox = self._ready.popleft()
            message, more = inbox.take()
            if more:
                self._ready.append(inbox)
            self.changed.notify_all()
            return message
