"""One stream of the tunnel, the same at both ends: frames in order, each once, and never more than was asked for."""

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.tasks import Tasks, cancel
from dock_gateway.sites.messages import Malformed
from dock_gateway.sites.tunnel.frames import (
    MAX_PIECE,
    OVERHEAD,
    WINDOW,
    Abort,
    Alive,
    Close,
    Credit,
    Frame,
    Message,
    encode,
    read_frame,
)

# What a message of a WebSocket may have, in bytes.
MAX_MESSAGE = 16 * 1024 * 1024
MAX_NUMBER = 10**15  # of a frame
# Seconds that a stream waits for the first frame of the other end: as long as the longest wait at a site may be set to.
LONGEST_WAIT = 3600.0
FINISHED = "finished"


@dataclass(frozen=True)
class Timing:
    """Seconds between signs of life, and without one until a stream ends."""

    alive: float = 5.0
    silence: float = 15.0


class ChannelEnded(OSError):
    """A stream has ended.

    Args:
        reason: A stable name: `finished`, `gap`, `silent`, `broker_unavailable`, …, or what the other end says.
        detail: A human-readable sentence.
    """

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(detail or reason)
        self.reason = reason
        self.detail = detail or reason


class Channel:
    """One stream, from its opening until `end`, `finish` or `abort`.

    Args:
        publish: Sends a message to the other end.
        max_payload: Bytes of the largest message that the broker takes.
        refuse: Called with the name of a reason and a sentence when a frame is dropped.
        on_end: Called once, when the stream has ended.
        timing: When the other end counts as gone.

    Attributes:
        ended: Why the stream has ended; None while it goes on.
    """

    def __init__(
        self,
        publish: Callable[[bytes], Coroutine[Any, Any, None]],
        *,
        max_payload: int,
        refuse: Callable[[str, str], None],
        on_end: Callable[[], None],
        timing: Timing,
    ) -> None:
        self.ended: ChannelEnded | None = None
        self._closed: ChannelEnded | None = None  # the other end has closed the WebSocket: it takes no more
        self._publish = publish
        self._piece = piece_of(max_payload)
        self._refuse = refuse
        self._on_end = on_end
        self._timing = timing
        self._sent = self._received = 0  # number of frames
        self._credit = WINDOW
        self._taken = self._waiting = 0  # bytes: taken and not credited yet, and in the queue
        self._queue: deque[tuple[Frame, bytes, int]] = deque()
        self._changed = asyncio.Event()  # something has arrived, or the end
        self._turn = asyncio.Lock()  # one message after the other
        self._wire = asyncio.Lock()  # numbers in the order of publication
        self._clock = asyncio.get_running_loop().time
        self._heard = self._clock()
        self._tasks = Tasks("keeping a stream alive")
        self._beat = self._tasks.spawn(self._keep_alive())

    # Input.

    def offer(self, data: bytes) -> None:
        """Take a message from the other end. Never waits."""
        if self.ended is not None:
            return
        try:
            frame, body = read_frame(data)
        except Malformed as error:
            self._refuse(error.reason, error.detail)
            return
        if isinstance(frame, Abort):  # whatever was lost before it
            self.end(frame.reason, frame.detail)
            return
        if frame.n <= self._received:
            self._refuse("duplicate", f"frame {frame.n} was received already")
            return
        if frame.n != self._received + 1:
            self._fail("gap", f"frames {self._received + 1} to {frame.n - 1} are missing")
            return
        self._received = frame.n
        self._heard = self._clock()
        if isinstance(frame, Credit):
            self._credit = min(WINDOW, self._credit + frame.bytes)
            self._changed.set()
        elif not isinstance(frame, Alive):
            if isinstance(frame, Close):
                self._closed = ChannelEnded("closed", frame.reason)
            self._put(frame, body, len(data) + OVERHEAD)

    def _put(self, frame: Frame, body: bytes, cost: int) -> None:
        self._waiting += cost
        if self._waiting + self._taken > WINDOW:
            self._fail("too_much", "more was sent than may be")
            return
        self._queue.append((frame, body, cost))
        self._changed.set()

    async def receive(self) -> tuple[Frame, bytes]:
        """Wait for the next frame and return it with its bytes. Its sender may send more when the next one is awaited.

        Raises:
            ChannelEnded: The stream has ended.
        """
        if self._taken >= WINDOW // 4:
            await self._give_credit()
        while True:
            if self.ended is not None:
                raise self.ended
            if self._queue:
                break
            await self._change()
        frame, body, cost = self._queue.popleft()
        self._waiting -= cost
        self._taken += cost
        return frame, body

    async def receive_first(self, silence: float) -> tuple[Frame, bytes]:
        """Wait for the next frame as long as the other end shows that it is there. It may be waiting for a person.

        Args:
            silence: Seconds without a sign of life after which it counts as gone.

        Raises:
            ChannelEnded: The stream has ended.
            TimeoutError: The other end was silent, or has worked for longer than anything takes.
        """
        async with asyncio.timeout(LONGEST_WAIT):
            receiving = asyncio.ensure_future(self.receive())
            try:
                while not receiving.done():
                    left = self._heard + silence - self._clock()
                    if left <= 0:
                        raise TimeoutError
                    await asyncio.wait({receiving}, timeout=left)
                return receiving.result()
            finally:
                await cancel(receiving)

    async def _give_credit(self) -> None:
        taken, self._taken = self._taken, 0
        try:
            await self._send({"type": "credit", "bytes": taken})
        except asyncio.CancelledError:
            self._taken += taken
            raise

    async def receive_message(self, first: Message, body: bytes) -> str | bytes:
        """Return the message of a WebSocket that begins with this frame.

        Raises:
            ChannelEnded: The stream has ended, or does so now as the message is not valid.
        """
        pieces, size, frame = [body], len(body), first
        while frame.more:
            following, body = await self.receive()
            size += len(body)
            if not isinstance(following, Message) or following.type != first.type or size > MAX_MESSAGE:
                raise self._fail("malformed", "a message of a WebSocket is not complete, or too long")
            frame = following
            pieces.append(body)
        whole = b"".join(pieces)
        if first.type == "bytes":
            return whole
        try:
            return whole.decode()
        except UnicodeDecodeError:
            raise self._fail("malformed", "a text of a WebSocket is not UTF-8") from None

    async def wait_ended(self) -> ChannelEnded:
        """Wait until the stream has ended, and return why."""
        while self.ended is None:
            await self._change()
        return self.ended

    async def _change(self) -> None:
        self._changed.clear()
        await self._changed.wait()

    # Output.

    async def send(self, kind: str, **fields: Any) -> None:
        """Send a frame without bytes, when the other end has room for it.

        Raises:
            ChannelEnded: The stream has ended.
        """
        async with self._turn:
            await self._send_paid({"type": kind, **fields})

    async def send_data(self, body: bytes) -> None:
        """Send bytes of a body.

        Raises:
            ChannelEnded: The stream has ended.
        """
        async with self._turn:
            for start in range(0, len(body), self._piece):
                await self._send_paid({"type": "data"}, body[start : start + self._piece])

    async def send_message(self, message: str | bytes) -> None:
        """Send a message of a WebSocket.

        Raises:
            ChannelEnded: The stream has ended.
        """
        kind, body = ("text", message.encode()) if isinstance(message, str) else ("bytes", message)
        async with self._turn:
            for start in range(0, len(body) or 1, self._piece):
                end = start + self._piece
                await self._send_paid({"type": kind, "more": end < len(body)}, body[start:end])

    async def _send_paid(self, fields: dict[str, Any], body: bytes = b"") -> None:
        most = len(encode({**fields, "n": MAX_NUMBER})) + len(body) + OVERHEAD
        while self._credit < most and self.ended is None and self._closed is None:
            await self._change()
        if self._closed is not None:
            raise self._closed
        cost = await self._send(fields, body) + OVERHEAD
        self._credit -= cost  # not before: it may have grown meanwhile

    async def _send(self, fields: dict[str, Any], body: bytes = b"") -> int:
        async with self._wire:
            if self.ended is not None:
                raise self.ended
            message = encode({**fields, "n": self._sent + 1}, body)
            try:
                await self._publish(message)
            except Unavailable as error:
                self.end(error.code, error.detail)
                raise ChannelEnded(error.code, error.detail) from None
            self._sent += 1
            return len(message)

    async def _keep_alive(self) -> None:
        while self.ended is None:
            await asyncio.sleep(self._timing.alive)
            if self._clock() - self._heard > self._timing.silence:
                await self.abort("silent", f"nothing was heard for {self._timing.silence:g} s")
                return
            try:
                await self._send({"type": "alive"})
            except ChannelEnded:
                return

    # The end.

    def finish(self) -> None:
        """End the stream as it should end. Idempotent."""
        self.end(FINISHED, "the stream is complete")

    def end(self, reason: str, detail: str) -> None:
        """End the stream at this end only. Idempotent."""
        if self.ended is None:
            self.ended = ChannelEnded(reason, detail)
            self._queue.clear()
            self._changed.set()
            self._beat.cancel()
            self._on_end()

    async def abort(self, reason: str, detail: str) -> None:
        """End the stream, and ask the other end to do so, if it can be reached. Idempotent."""
        if self.ended is None:
            try:
                await self._send({"type": "abort", "reason": reason, "detail": detail})
            except ChannelEnded:
                return
            self.end(reason, detail)

    def _fail(self, reason: str, detail: str) -> ChannelEnded:
        """End the stream at both ends, without waiting for that."""
        if self.ended is None:
            self._refuse(reason, detail)
            message = encode({"type": "abort", "reason": reason, "detail": detail, "n": self._sent + 1})
            self.end(reason, detail)
            self._tasks.spawn(self._publish(message))
        assert self.ended is not None
        return self.ended


def piece_of(max_payload: int) -> int:
    """Return how many raw bytes a message has at most; the rest of what the broker takes is for the line before."""
    return min(MAX_PIECE, max_payload // 2)
