"""HTTP/1.1 as h11 reads it, but as strictly as RFC 9112 asks for.

What one reader takes for the end of a request and another one does not lets a client slip a request past a proxy. So
what leaves room for two readings is refused, although h11 would accept it.
"""

import re
from typing import Any

import h11

from dock_gateway.http.edge.targets import read_request_line

# A line feed without its carriage return; a line that continues the one before.
BARE_LINE_FEED = re.compile(rb"(?<!\r)\n")
# Empty lines before a request mean nothing (RFC 9112, 2.2). Only a few: each costs time.
EMPTY_LINES = b"\r\n" * 4
BEFORE_REQUEST = re.compile(rb"(?:\r\n){1,4}(?=[^\r\n])")
FOLDED_LINE = re.compile(rb"\n[ \t]")
CONTENT_LENGTH = re.compile(rb"^content-length:[ \t]*([^\r\n]*?)[ \t]*\r?$", re.IGNORECASE | re.MULTILINE)


class StrictConnection(h11.Connection):
    """The parser of one connection.

    Args:
        max_head: Maximum size of a request's head, in bytes.

    Attributes:
        host: What an HTTP/1.0 request without the header `Host` means.
    """

    def __init__(self, max_head: int) -> None:
        super().__init__(h11.SERVER, max_head)
        self.host = b""
        self._chunked = False  # the body that is being read
        self._last = b""  # the two bytes before the next ones, unless they are of the body

    def next_event(self) -> Any:
        """Return the next event, as h11 does.

        Raises:
            h11.RemoteProtocolError: The client has sent something that is not HTTP, or can be read in two ways.
        """
        if self.their_state is not h11.IDLE and not self._chunked:
            return super().next_event()
        before = self.trailing_data[0]
        if self.their_state is h11.IDLE and before:
            if EMPTY_LINES.startswith(before):
                return h11.NEED_DATA
            if (empty := BEFORE_REQUEST.match(before)) is not None:
                self._receive_buffer.maybe_extract_at_most(empty.end())
                before = before[empty.end() :]
        event = super().next_event()
        read = before[: len(before) - len(self.trailing_data[0])]
        if isinstance(event, h11.Request):
            _check_lines(read)
            self._chunked = any(name == b"transfer-encoding" for name, _ in event.headers)
            _check_framing(event, read, chunked=self._chunked)
            self._last = b""
            return self._understood(event)
        if isinstance(event, h11.EndOfMessage):
            _check_lines(self._last + read)  # its trailers
            self._chunked = False
        self._last = b"" if isinstance(event, h11.Data) else (self._last + read)[-2:]
        return event

    def _understood(self, event: h11.Request) -> h11.Request:
        """Return a request with what its line asks for; the address in it counts, not the header (RFC 9112, 3.2.2)."""
        if not event.http_version.startswith(b"1."):
            raise h11.RemoteProtocolError(f"HTTP/{event.http_version.decode()} is not spoken here")
        try:
            method, target, host = read_request_line(event.method, event.target)
        except ValueError as error:
            raise h11.RemoteProtocolError(str(error)) from None
        headers = event.headers.raw_items()
        if host is None and event.http_version == b"1.0" and not any(name == b"host" for name, _ in event.headers):
            host = self.host
        if host is not None:
            headers = [(b"Host", host), *(pair for pair in headers if pair[0].lower() != b"host")]
        return h11.Request(method=method, target=target, headers=headers, http_version=event.http_version)


def _check_lines(head: bytes) -> None:
    if BARE_LINE_FEED.search(head):
        raise h11.RemoteProtocolError("a line ends with a line feed alone, not with CR LF")
    if FOLDED_LINE.search(head):
        raise h11.RemoteProtocolError("a header goes on in the next line")


def _check_framing(event: h11.Request, head: bytes, *, chunked: bool) -> None:
    """Refuse a request whose end could be in two places (RFC 9112, 6.1 and 6.3)."""
    lengths = CONTENT_LENGTH.findall(head)
    if chunked and lengths:
        raise h11.RemoteProtocolError("it has both Content-Length and Transfer-Encoding")
    if chunked and event.http_version < b"1.1":
        raise h11.RemoteProtocolError("it has a Transfer-Encoding, which HTTP/1.0 does not know")
    if len(lengths) > 1 or not all(length.isdigit() for length in lengths):
        raise h11.RemoteProtocolError("it has more than one Content-Length")
