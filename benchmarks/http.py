"""A keep-alive HTTP/1.1 client that costs next to nothing, so that what it measures is the server."""

import socket
import time
from collections.abc import Callable
from http import HTTPStatus
from typing import Any, Self

import orjson


class KeptConnection:
    """A connection that is made anew when it has been idle for longer than servers keep it."""

    IDLE = 2.0

    def __init__(self, make: Callable[[], "Connection"]) -> None:
        self._make = make
        self._connection: Connection | None = None
        self._used = 0.0

    def get(self) -> "Connection":
        """The connection, ready for use."""
        if self._connection is None or time.monotonic() - self._used > self.IDLE:
            if self._connection is not None:
                self._connection.__exit__()
            self._connection = self._make()
        self._used = time.monotonic()
        return self._connection


class Connection:
    """One connection to a server on this machine; blocking, one request at a time."""

    def __init__(self, port: int, timeout: float = 30.0, headers: str = "") -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._headers = f"Host: 127.0.0.1:{port}\r\nContent-Type: application/json\r\n{headers}"

    def request(self, method: str, path: str, body: object = None, headers: str = "") -> tuple[int, Any]:
        """Send a request and return the status and the decoded JSON."""
        content = b"" if body is None else orjson.dumps(body)
        head = f"{method} {path} HTTP/1.1\r\n{self._headers}{headers}Content-Length: {len(content)}\r\n\r\n"
        self._socket.sendall(head.encode() + content)
        data = b""
        while (end := data.find(b"\r\n\r\n")) < 0:
            data += self._read()
        lines = data[:end].split(b"\r\n")
        fields = dict(line.lower().split(b": ", 1) for line in lines[1:])
        length = int(fields.get(b"content-length", 0))
        answer = data[end + 4 :]
        while len(answer) < length:
            answer += self._read()
        return int(lines[0].split()[1]), orjson.loads(answer) if answer else None

    def time(self, method: str, path: str) -> float:
        """Send a request, and return the milliseconds to its answer, which must be a good one."""
        start = time.perf_counter()
        status, answer = self.request(method, path)
        assert status == HTTPStatus.OK, answer
        return (time.perf_counter() - start) * 1e3

    def _read(self) -> bytes:
        data = self._socket.recv(65536)
        if not data:
            raise ConnectionError("the server closed the connection")
        return data

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()
