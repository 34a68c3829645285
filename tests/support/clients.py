"""The HTTP and WebSocket clients of the suite. What they receive is compared with the OpenAPI document."""

import threading
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import httpx2
import orjson
import websockets.sync.client
from websockets.exceptions import ConcurrencyError, ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection
from websockets.typing import Data

from tests.support import shapes
from tests.support.waiting import PATIENCE

EVENT_STREAM = "text/event-stream"


class HttpClient(httpx2.Client):
    """A client of a gateway. Streamed answers are compared by who reads them: `server_sent_events`."""

    def __init__(self, url: str = "", **options: Any) -> None:
        # Reading the certificates of the machine, which no gateway of the suite has, would take 25 ms each time.
        super().__init__(base_url=url, trust_env=False, verify=False, **{"timeout": PATIENCE} | options)

    def send(self, request: httpx2.Request, *, stream: bool = False, **options: Any) -> httpx2.Response:
        response = super().send(request, stream=stream, **options)
        if not stream or response.is_error:
            body = response.read()
            kind = response.headers.get("content-type", "")
            if not kind.startswith(EVENT_STREAM):
                shapes.check_answer(request.method, request.url.path, response.status_code, kind, body)
            else:
                for _ in _events(request.url.path, body.decode().split("\n")):
                    pass
        return response


class ReadingToTheEnd(ClientConnection):
    """A WebSocket that is closed at once, also where nobody has read what has come.

    `close` waits for the other end to close, too, which is read only after all that came before: with a full buffer it
    would wait in vain, for ten seconds.
    """

    def close(self, *reason: Any, **more: Any) -> None:
        reader = threading.Thread(target=self._read_on)
        reader.start()
        super().close(*reason, **more)
        reader.join()

    def _read_on(self) -> None:
        with suppress(ConnectionClosed, ConcurrencyError):  # the latter: somebody reads still
            while True:
                super().recv(decode=False)


class Connection(ReadingToTheEnd):
    """A WebSocket to a gateway."""

    def recv(self, timeout: float | None = None, decode: bool | None = None) -> Data:
        message = super().recv(timeout, decode)
        assert self.request is not None
        shapes.check_event(self.request.path, message)
        return message


def open_websocket(url: str, **options: Any) -> ClientConnection:
    """Open a WebSocket whose messages are compared with nothing."""
    return websockets.sync.client.connect(url, **{"create_connection": ReadingToTheEnd} | options)


def connect(url: str, **options: Any) -> ClientConnection:
    """Open a WebSocket to a gateway.

    Raises:
        InvalidStatus: The gateway refused it.
    """
    try:
        return open_websocket(url, max_size=None, create_connection=Connection, **options)
    except InvalidStatus as refused:
        response = refused.response
        kind = response.headers.get("content-type", "")
        shapes.check_answer("GET", httpx2.URL(url).path, response.status_code, kind, bytes(response.body or b""))
        raise


def server_sent_events(response: httpx2.Response) -> Iterator[tuple[str | None, dict[str, Any]]]:
    """Id and document of each event, read as EventSource does."""
    yield from _events(response.request.url.path, response.iter_lines())


def _events(path: str, lines: Any) -> Iterator[tuple[str | None, dict[str, Any]]]:
    identity, data = None, ""
    for line in lines:
        if line.startswith("id: "):
            identity = line[4:]
        elif line.startswith("data: "):
            data += line[6:]
        elif not line and data:
            shapes.check_event(path, data)
            yield identity, orjson.loads(data)
            data = ""
