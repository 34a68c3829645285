"""Parses the target of a request line (RFC 9112, 3.2). A stop is recognized in every spelling."""

import re
from typing import NamedTuple
from urllib.parse import quote, unquote

METHOD, PATH = b"POST", b"/stop"
# A stop as it is passed on: of all, or of one site.
USUAL_PATH = re.compile(r"(?:/sites/[^/]+)?/stop")
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
    if (stop := stop_path(method, path)) is not None:
        return RequestLine(METHOD, stop + mark + query, host)
    return RequestLine(method, target, host)


def stop_path(method: bytes, path: bytes) -> bytes | None:
    """Return the usual path of a stop, as written or not: `/stop/`, `//stop`, `/%53TOP`, `/x/../stop;v=1`; else None.

    Below a site it is the same: `/sites/berlin//STOP` is `/sites/berlin/stop`. No other request can be
    meant, and a robot that was to stop must not go on over a slash.
    """
    if method.upper() != METHOD:
        return None
    parts = unquote(path.decode("ascii", "replace")).split("/")
    if _names(parts) == ["stop"]:
        return PATH
    match _names(parts, within_site=True):
        case ["sites", site, "stop"]:
            return b"/sites/" + quote(site, safe="").encode() + PATH
    return None


def is_stop(method: str, path: str) -> bool:
    """Return whether a request that was read is a stop."""
    return method.encode() == METHOD and USUAL_PATH.fullmatch(path) is not None


def _names(parts: list[str], *, within_site: bool = False) -> list[str]:
    """Return the names in a path. `..` does not lead above its root, which may be that of a site."""
    names: list[str] = []
    for part in parts:
        name = part.partition(";")[0].strip().lower()
        if name == "..":
            if not (within_site and len(names) == 2 and names[0] == "sites"):
                del names[-1:]
        elif name not in ("", "."):
            names.append(name)
    return names


def begins_stop(data: bytes) -> bool:
    """Return whether the first bytes of a request are those of a stop."""
    method, _, rest = data[:200].lstrip(b"\r\n").partition(b" ")
    if method.upper() != METHOD:
        return False
    try:
        target = read_request_line(method, rest.partition(b" ")[0]).target
    except ValueError:
        return False
    return is_stop("POST", target.partition(b"?")[0].decode("latin-1"))
