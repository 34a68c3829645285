"""The addresses of NATS servers, with and without their secrets."""

from dataclasses import dataclass, field
from urllib.parse import unquote, urlsplit

PORT = 4222


@dataclass(frozen=True)
class ServerAddress:
    """One NATS server. As text it has no user and no password.

    Attributes:
        tls: Whether nothing may be sent in the clear.
        user: The user, or a token if there is no password.
    """

    host: str
    port: int
    tls: bool
    user: str | None = field(default=None, repr=False)
    password: str | None = field(default=None, repr=False)

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'tls' if self.tls else 'nats'}://{host}:{self.port}"


def read_server(url: str) -> ServerAddress:
    """Read `nats://[user:password@]host[:port]` or `tls://…`.

    Raises:
        ValueError: It is something else. The text repeats nothing of the URL, which may have a password.
    """
    try:
        parts = urlsplit(url.strip())
        port = PORT if parts.port is None else parts.port
    except ValueError:
        raise ValueError("a NATS URL has an invalid host or port") from None
    if parts.scheme not in {"nats", "tls"} or not parts.hostname:
        raise ValueError("a NATS URL must look like tls://nats.example.com:4222 or nats://localhost:4222")
    if parts.path.strip("/") or parts.query or parts.fragment:
        raise ValueError("a NATS URL must end after the port; a / ? or # in a password is written %2F %3F %23")
    user = None if parts.username is None else unquote(parts.username)
    password = None if parts.password is None else unquote(parts.password)
    return ServerAddress(parts.hostname, port, parts.scheme == "tls", user, password)
