"""The load client: many connections that read feedback and note how old it is when it arrives."""

import asyncio
import re
import time
from array import array
from collections.abc import Callable, Mapping

from picows import WSFrame, WSListener, WSMsgType, WSTransport, ws_connect

STAMP = re.compile(rb'"sec":\s*(\d+),\s*"nanosec":\s*(\d+)')
# The same in CBOR: the seconds have four bytes, the nanoseconds as many as they need.
CBOR_STAMP = re.compile(rb"csec\x1a(.{4})gnanosec(?:\x1a(.{4})|\x19(.{2})|\x18(.)|([\0-\x17]))", re.DOTALL)


class Tally:
    """What all readers of one run received."""

    def __init__(self) -> None:
        self.latencies = array("d")
        self.stamps: set[int] = set()
        self.last_ns = 0  # when the newest arrived

    def note(self, text: bytes, now_ns: int) -> None:
        """A feedback message arrived."""
        if match := STAMP.search(text):
            self._add(int(match[1]), int(match[2]), now_ns)

    def note_cbor(self, data: bytes, now_ns: int) -> None:
        """A message in CBOR arrived."""
        if match := CBOR_STAMP.search(data):
            self._add(int.from_bytes(match[1]), int.from_bytes(match[match.lastindex or 2]), now_ns)

    def _add(self, seconds: int, nanoseconds: int, now_ns: int) -> None:
        sent = seconds * 1_000_000_000 + nanoseconds
        self.latencies.append((now_ns - sent) / 1e6)
        self.stamps.add(sent)
        self.last_ns = now_ns

    async def settle(self, expected: int, patience: float = 2.0) -> None:
        """Wait until everything is there, or nothing has come for a while."""
        seen, since = -1, time.monotonic()
        while len(self.latencies) < expected and time.monotonic() - since < patience:
            if len(self.latencies) != seen:
                seen, since = len(self.latencies), time.monotonic()
            await asyncio.sleep(0.02)


class WebSocketReader(WSListener):  # type: ignore[misc]
    """Reads messages. Texts that hold `mark` near their beginning are feedback, and all binary messages, in CBOR."""

    def __init__(self, tally: Tally, mark: bytes, others: Callable[[bytes], None] = lambda _: None) -> None:
        super().__init__()
        self._tally = tally
        self._mark = mark
        self._others = others
        self.begun = asyncio.get_running_loop().create_future()

    def on_ws_frame(self, transport: WSTransport, frame: WSFrame) -> None:
        """A message arrived."""
        now_ns = time.time_ns()
        if frame.msg_type == WSMsgType.BINARY:
            self._tally.note_cbor(frame.get_payload_as_bytes(), now_ns)
            return
        if frame.msg_type != WSMsgType.TEXT:
            if frame.msg_type == WSMsgType.CLOSE:
                transport.disconnect()
            return
        text = frame.get_payload_as_bytes()
        if self._mark in text[:200]:
            self._tally.note(text, now_ns)
            return
        if not self.begun.done():
            self.begun.set_result(None)
        self._others(text)


async def connect(
    url: str, reader: Callable[[], WebSocketReader], headers: Mapping[str, str] | None = None
) -> tuple[WSTransport, WebSocketReader]:
    """Open one connection."""
    options = {"websocket_handshake_timeout": 30, "use_aiofastnet": False, "extra_headers": dict(headers or {})}
    transport, listener = await ws_connect(reader, url, **options)
    return transport, listener


class EventStreamReader(asyncio.Protocol):
    """Reads Server-Sent Events."""

    def __init__(self, tally: Tally, request: bytes) -> None:
        self._tally = tally
        self._request = request
        self._rest = b""
        self.begun = asyncio.get_running_loop().create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Ask for the stream."""
        transport.write(self._request)  # type: ignore[attr-defined]

    def data_received(self, data: bytes) -> None:
        """Some events, or a part of one."""
        now_ns = time.time_ns()
        if not self.begun.done():
            status = data.partition(b"\r\n")[0].decode()
            if " 200 " in status:
                self.begun.set_result(None)
            else:
                self.begun.set_exception(ConnectionError(status))
        *events, self._rest = (self._rest + data).split(b"\n\n")
        for event in events:
            if b"event: feedback" in event:
                self._tally.note(event, now_ns)
