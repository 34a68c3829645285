"""Chooses the headers that travel through the tunnel. Each end decides for itself, whatever the other one sends."""

from collections.abc import Iterable

Pairs = list[tuple[bytes, bytes]]

# What belongs to one connection, not to an answer.
_HOP_BY_HOP = frozenset({
    "connection", "keep-alive", "proxy-connection", "te", "trailer", "transfer-encoding", "upgrade",
})  # fmt: skip
# What belongs to the connection of the hub's own client, or says who that is.
_STAYING = _HOP_BY_HOP | {
    "authorization", "content-length", "cookie", "expect", "forwarded", "host", "origin", "permissions-policy",
    "referer", "x-real-ip",
}  # fmt: skip
_STAYING_PREFIXES = ("proxy-", "sec-", "x-forwarded-")


def _travels(name: str) -> bool:
    return name not in _STAYING and not name.startswith(_STAYING_PREFIXES)


def write_request_headers(headers: Iterable[tuple[bytes, bytes]]) -> list[tuple[str, str]]:
    """Return those headers of a request that go to the site, as a message has them."""
    return [(name, value) for name, value in _decoded(headers) if _travels(name)]


def read_request_headers(headers: Iterable[tuple[str, str]]) -> Pairs:
    """Return those headers of a request from the hub that its site takes, as ASGI has them."""
    return read_headers((name, value) for name, value in headers if _travels(name))


def write_answer_headers(headers: Iterable[tuple[bytes, bytes]]) -> list[tuple[str, str]]:
    """Return the headers of an answer that go to the hub, as a message has them."""
    return [(name, value) for name, value in _decoded(headers) if name not in _HOP_BY_HOP]


def read_headers(headers: Iterable[tuple[str, str]]) -> Pairs:
    """Return headers as ASGI has them."""
    return [(name.encode("latin-1"), value.strip().encode("latin-1")) for name, value in headers]


def _decoded(headers: Iterable[tuple[bytes, bytes]]) -> Iterable[tuple[str, str]]:
    return ((name.decode("latin-1").lower(), value.decode("latin-1").strip()) for name, value in headers)
