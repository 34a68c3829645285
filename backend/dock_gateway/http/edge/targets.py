"""Parses the target of a request line (RFC 9112, 3.2). A stop is recognized in every spelling."""

import re
from typing import NamedTuple
from urllib.parse import unquote

METHOD, PATH = b"POST", b"/stop"
# An address instead of a path, as clients send it that believe to speak to a proxy. A user in it is an error: it would
# make the host look like another one (RFC 9110, 4.2.4).
ABSOLUTE = re.compile(rb"(?:https?|wss?)://(?P<authority>[^/?#@\\]+)(?P<rest>[/?#].*)?", re.IGNORECASE)


class RequestLine(NamedTuple):
    """The target of a request.

    Attributes:
        method: The method.
        target: The path, with the query if there is one.
        host: Overrides the header `Host`; None: the header counts.
    """

    method: bytes
    target: bytes
    host: bytes | None = None


def read_request_line(method: bytes, target: bytes) -> RequestLine:
    """Return what a request line asks for: a path, whether it has one or a whole address. A stop has its usual path.

    Raises:
        ValueError: The target is neither a path nor an address of HTTP or of a WebSocket, or there is a user in it.
    """
    host = None
    if (absolute := ABSOLUTE.fullmatch(target)) is not None:
        host, rest = absolute["authority"], absolute["rest"] or b""
        target = rest if rest.startswith(b"/") else b"/" + rest
    if not target.startswith(b"/"):
        raise ValueError("the target is neither a path nor an http:// address without a user")
    path, mark, query = target.partition(b"#")[0].partition(b"?")
    if is_stop(method, path):
        return RequestLine(METHOD, PATH + mark + query, host)
    return RequestLine(method, target, host)


def is_stop(method: bytes, path: bytes) -> bool:
    """Return whether a request is a stop, as written or not: `/stop/`, `//stop`, `/%53TOP`, `/x/../stop;v=1`.

    No other request can be meant, and a robot that was to stop must not go on over a slash.
    """
    if method.upper() != METHOD:
        return False
    parts: list[str] = []
    for part in unquote(path.decode("ascii", "replace")).split("/"):
        name = part.partition(";")[0].strip()
        if name == "..":
            del parts[-1:]
        elif name not in ("", "."):
            parts.append(name)
    return [part.lower() for part in parts] == ["stop"]


def begins_stop(data: bytes) -> bool:
    """Return whether the first bytes of a request are those of a stop."""
    method, _, rest = data[:200].lstrip(b"\r\n").partition(b" ")
    if method.upper() != METHOD:
        return False
    try:
        return read_request_line(method, rest.partition(b" ")[0]).target.partition(b"?")[0] == PATH
    except ValueError:
        return False
