"""The common part of both clients: a gateway's address, its requests, and the meaning of its answers. No I/O."""

import math
import os
import ssl
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from random import uniform
from typing import Any, TypeVar
from urllib.parse import urlsplit

import httpx2
import orjson
from websockets.exceptions import ConnectionClosed, InvalidStatus

from dock_gateway.client.calls import Call
from dock_gateway.client.documents import Event
from dock_gateway.client.errors import ClientError, ClientTimeout, GatewayRefused, GatewayUnreachable

T = TypeVar("T")
URL = "http://127.0.0.1:8000"
FIRST_DELAY, LONGEST_DELAY = 0.1, 2.0
# Statuses of a gateway that starts, ends or has too many clients: a stream tries again.
BUSY = (429, 502, 503, 504)
LOGIN_ENDED = 4401
# Seconds in which a stream has to open.
OPEN_WITHIN = 10.0
# Seconds before a deadline that are not worth another attempt.
CLOSE = 0.01
# Events that a stream recognizes if they come again.
REMEMBERED = 1000


def tls_context(url: str, certificate: str | None = None) -> ssl.SSLContext | None:
    """Return how an https:// address is connected to; None for others.

    The authorities are those of the system, or those in the file SSL_CERT_FILE.

    Args:
        url: Of the gateway.
        certificate: A file with a certificate and its key, for a gateway that asks for one; None: that in
            DOCK_GATEWAY_CLIENT_CERT, if any.

    Raises:
        ClientError: That file cannot be used.
    """
    if not url.lower().startswith("https:"):
        return None
    context = ssl.create_default_context()
    path = certificate or os.environ.get("DOCK_GATEWAY_CLIENT_CERT")
    if path:
        try:
            context.load_cert_chain(path)
        except OSError as error:
            source = "the client certificate" if certificate else "DOCK_GATEWAY_CLIENT_CERT"
            raise ClientError(f"{source}: {path} cannot be used: {error}") from None
    return context


class Connection:
    """The address of a gateway, and the options of the HTTP and WebSocket libraries for it.

    Attributes:
        url: The base URL.
        timeout: Seconds that an answer may take, in addition to what the gateway was asked to wait.
        patience: Seconds without the gateway after which a client gives up.
        reached: Whether the gateway has answered before. If not, an attempt that fails is not repeated.
    """

    def __init__(
        self, url: str | None, token: str | None, certificate: str | None, timeout: float, patience: float
    ) -> None:
        self.url = (url or os.environ.get("DOCK_GATEWAY_URL") or URL).rstrip("/")
        self.timeout = timeout
        self.patience = patience
        self.reached = False
        self._token = token or os.environ.get("DOCK_GATEWAY_TOKEN")
        try:
            address = urlsplit(self.url)
            host, _ = address.hostname, address.port
        except ValueError as error:
            raise ClientError(f"{self.url} is not the address of a gateway: {error}") from None
        if address.scheme not in ("http", "https") or not host:
            raise ClientError(f"{self.url} is not the address of a gateway: it should be like {URL}")
        self._local = host in ("127.0.0.1", "::1", "localhost")  # no proxy stands before this machine
        self._tls = tls_context(self.url, certificate)

    @property
    def _headers(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self._token}"} if self._token else {}

    @property
    def http_options(self) -> dict[str, Any]:
        """Arguments of an HTTP client."""
        return {
            "base_url": self.url,
            "headers": self._headers,
            "timeout": self.timeout,
            "trust_env": not self._local,
            "verify": self._tls or True,
        }

    @property
    def stream_options(self) -> dict[str, Any]:
        """Arguments of a WebSocket. A dead connection is noticed by pings; its end is not waited for."""
        tls = {"ssl": self._tls} if self._tls else {}
        keepalive = {"ping_interval": 5, "ping_timeout": 10, "close_timeout": 1}
        proxy = None if self._local else True
        return {"additional_headers": self._headers, "max_size": None, "proxy": proxy, **tls, **keepalive}

    def read(self, response: httpx2.Response, read: Callable[[Any], T]) -> T:
        """Return what an answer contains.

        Raises:
            ClientError: It does not come from a gateway, or refuses (`GatewayRefused`).
        """
        if not response.is_success:
            raise refusal(response.status_code, response.content)
        with self.understood():
            content = read(orjson.loads(response.content) if response.content else None)
        self.reached = True
        return content

    @contextmanager
    def understood(self) -> Iterator[None]:
        """Read an answer of a gateway within: one that cannot be read is an error.

        Raises:
            ClientError: It is none of a gateway.
        """
        try:
            yield
        except (ValueError, KeyError, TypeError):
            text = f"{self.url} is not a dock-gateway, or one of another version"
            raise ClientError(text) from None

    def unreachable(self, error: Exception) -> GatewayUnreachable:
        """Return the error that says so."""
        return GatewayUnreachable(f"no gateway answers at {self.url} ({error or type(error).__name__})")


class Retry:
    """The delays after failed attempts, and the time when to give up.

    Args:
        connection: To the gateway.
        deadline: When to give up in any case, on the monotonic clock.
    """

    def __init__(self, connection: Connection, deadline: float | None = None) -> None:
        self._connection = connection
        self._deadline = deadline
        self.succeeded()

    def succeeded(self) -> None:
        """The gateway is there: the next failure is the first one."""
        self._delay = FIRST_DELAY
        self._failing_since: float | None = None

    def left(self, most: float) -> float:
        """Return the seconds until the deadline, at most this many."""
        return most if self._deadline is None else max(0.0, min(most, self._deadline - time.monotonic()))

    def failed(self, error: Exception) -> float:
        """Return the seconds to wait before the next attempt.

        Raises:
            ClientError: There is none.
        """
        if isinstance(error, ConnectionClosed) and error.rcvd is not None and error.rcvd.code == LOGIN_ENDED:
            raise GatewayRefused(401, {"code": error.rcvd.reason, "detail": "the login of this stream has ended"})
        now = time.monotonic()
        if self.left(math.inf) <= CLOSE:
            raise ClientTimeout("the goal has not ended in time") from error
        self._failing_since = self._failing_since or now
        over = self._is_over(error, now)
        if isinstance(error, InvalidStatus):
            if over or error.response.status_code not in BUSY:
                raise refusal(error.response.status_code, error.response.body)
        elif over:
            raise self._failure(error) from error
        delay = self._delay * uniform(0.5, 1.0)  # noqa: S311 - so that many clients do not come back at once
        self._delay = min(2 * self._delay, LONGEST_DELAY)
        return self.left(delay)

    def _is_over(self, _: Exception, now: float) -> bool:
        assert self._failing_since is not None
        return not self._connection.reached or now - self._failing_since >= self._connection.patience

    def _failure(self, error: Exception) -> ClientError:
        return self._connection.unreachable(error)


class Attempts(Retry):
    """The attempts of a request.

    Args:
        connection: To the gateway.
        call: The request.
        deadline: When to give up in any case, on the monotonic clock.
    """

    def __init__(self, connection: Connection, call: Call[Any], deadline: float | None = None) -> None:
        super().__init__(connection, deadline)
        self._call = call
        self._begun = time.monotonic()

    @property
    def timeout(self) -> httpx2.Timeout:
        """The time limits of the next attempt."""
        most = self._connection.timeout
        return httpx2.Timeout(self.left(most + self._call.wait), connect=self.left(most))

    def _is_over(self, error: Exception, now: float) -> bool:
        if not self._call.repeatable:
            return True
        if _timed_out(error) and now - self._begun < self._connection.timeout + self._call.rejoins:
            return False
        return super()._is_over(error, now)

    def _failure(self, error: Exception) -> ClientError:
        if not _timed_out(error):
            return super()._failure(error)
        waited = time.monotonic() - self._begun
        text = f"{self._connection.url} has not answered within {waited:.3g} s; what was asked for may be carried out"
        return ClientTimeout(text)


def _timed_out(error: Exception) -> bool:
    """Whether the gateway was there, and did not answer in time."""
    return isinstance(error, httpx2.ReadTimeout | httpx2.WriteTimeout)


def refusal(status: int, body: bytes | bytearray | None) -> GatewayRefused:
    """Return the error that an answer is. A proxy's says nothing but its status."""
    try:
        return GatewayRefused(status, orjson.loads(body or b""))
    except orjson.JSONDecodeError:
        return GatewayRefused(status)


class ReadPosition:
    """The position in a stream, where the next connection resumes; and the time until which it is read."""

    def __init__(
        self, connection: Connection, query: Mapping[str, object], after: str | None, deadline: float | None = None
    ) -> None:
        self._resumed = False
        self._connection = connection
        self._query = query
        self._after = after
        self._seen: dict[str, None] = {}
        self._retry = Retry(connection, deadline)
        self._deadline = deadline

    @property
    def url(self) -> str:
        """The address of the stream, from where it was left."""
        query: dict[str, Any] = {**self._query, "after": self._after}
        params = httpx2.QueryParams({name: value for name, value in query.items() if value is not None})
        return f"{self._connection.url.replace('http', 'ws', 1)}/ws/feedback?{params}"

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of the next connection."""
        return {**self._connection.stream_options, "open_timeout": self._retry.left(OPEN_WITHIN)}

    @property
    def left(self) -> float | None:
        """Seconds until the deadline, if there is one."""
        return None if self._deadline is None else self._retry.left(math.inf)

    def read(self, message: str | bytes) -> Event | None:
        """Return an event; None if it has come before."""
        self._connection.reached = True
        self._retry.succeeded()
        with self._connection.understood():
            event = Event.read(orjson.loads(message))
        if event.id is not None:
            if event.type in ("snapshot", "heartbeat"):  # the id is that of the last event before them
                self._after = max(event.id, self._after or "")
                return event
            if event.id in self._seen:
                return None
            self._seen[event.id] = None
            if len(self._seen) > REMEMBERED:
                del self._seen[next(iter(self._seen))]
            self._after = max(event.id, self._after or "")
        return event

    def lost(self, error: Exception) -> float:
        """Return the seconds to wait before the stream is opened again.

        Raises:
            ClientError: It cannot be.
        """
        self._resumed = True
        return self._retry.failed(error)

    def to_be_checked(self, event: Event) -> bool:
        """Whether to ask how a goal is: at another gateway, a stream that resumes can miss a goal's end."""
        return self._resumed and event.type == "heartbeat"
