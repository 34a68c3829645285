"""The messages of the tunnel: one line of JSON, then raw bytes. Both ends are on other machines: all is checked."""

from typing import Annotated, Any, Literal

import orjson
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError

from dock_gateway.sites.messages import Malformed, malformed
from dock_gateway.sites.subjects import ID_PATTERN

# Bytes of the line, and of the raw bytes after it.
MAX_LINE, MAX_PIECE = 256 * 1024, 128 * 1024
# What either end may send of a stream before the other one has taken it, in bytes; a frame costs some more than it has.
WINDOW, OVERHEAD = 1024 * 1024, 256

# The request that is never one too many.
STOP = ("POST", "/stop")

Name = Annotated[str, StringConstraints(max_length=256, pattern=r"^[!#$%&'*+\-.^_`|~0-9a-z]+$")]
Value = Annotated[str, StringConstraints(max_length=65_536, pattern=r"^[\t\x20-\x7e\u0080-\u00ff]*$")]
Headers = Annotated[list[tuple[Name, Value]], Field(max_length=200)]
Token = Annotated[str, StringConstraints(max_length=256)]


class _Message(BaseModel):
    # Another release may say more.
    model_config = ConfigDict(frozen=True, extra="ignore")


class Open(_Message):
    """Opens a stream: an HTTP request, or the handshake of a WebSocket.

    Attributes:
        token: Who asks, signed.
        path: Decoded, without the query.
        query: As the client sent it.
        client: The address of the client at the hub.
        more: Whether more of the body follows in frames.
    """

    id: Annotated[str, Field(pattern=ID_PATTERN)]
    token: Annotated[str, Field(max_length=100_000)]
    kind: Literal["http", "websocket"]
    method: Annotated[str, Field(pattern=r"^[A-Z]{1,20}$")]
    path: Annotated[str, Field(max_length=8192, pattern=r"^/")]
    query: Annotated[str, Field(max_length=65_536, pattern=r"^[\x21-\x7e]*$")] = ""
    headers: Headers = []
    subprotocols: Annotated[list[Token], Field(max_length=20)] = []
    client: Annotated[str, Field(max_length=100)] = ""
    more: bool = False


class _Frame(_Message):
    n: Annotated[int, Field(ge=1)]


class Head(_Frame):
    """Status and headers of an answer."""

    type: Literal["head"]
    status: Annotated[int, Field(ge=200, le=599)]
    headers: Headers = []


class Data(_Frame):
    """Bytes of a body."""

    type: Literal["data"]


class End(_Frame):
    """The body that this end sends is complete."""

    type: Literal["end"]


class Accept(_Frame):
    """The WebSocket is open."""

    type: Literal["accept"]
    subprotocol: Token | None = None
    headers: Headers = []


class Message(_Frame):
    """A message of a WebSocket, or a piece of one if `more` follows."""

    type: Literal["text", "bytes"]
    more: bool = False


class Close(_Frame):
    """The WebSocket is closed by this end."""

    type: Literal["close"]
    code: Annotated[int, Field(ge=1000, le=4999)] = 1000
    reason: Annotated[str, Field(max_length=123)] = ""


class Credit(_Frame):
    """This end has taken so many bytes."""

    type: Literal["credit"]
    bytes: Annotated[int, Field(ge=1, le=WINDOW)]


class Alive(_Frame):
    """This end is still there."""

    type: Literal["alive"]


class Abort(_Frame):
    """The stream has failed at this end."""

    type: Literal["abort"]
    reason: Annotated[str, Field(max_length=64)] = "aborted"
    detail: Annotated[str, Field(max_length=8000)] = ""


Frame = Head | Data | End | Accept | Message | Close | Credit | Alive | Abort
_FRAMES: TypeAdapter[Frame] = TypeAdapter(Annotated[Frame, Field(discriminator="type")])


def encode(fields: dict[str, Any], body: bytes = b"") -> bytes:
    """Return a message."""
    return orjson.dumps(fields) + b"\n" + body


def read_open(data: bytes) -> tuple[Open, bytes]:
    """Read the message that opens a stream, and the first bytes of its body.

    Raises:
        Malformed: It is something else, or too large.
    """
    line, body = _split(data)
    try:
        return Open.model_validate_json(line), body
    except ValidationError as error:
        raise malformed(error) from None


def read_frame(data: bytes) -> tuple[Frame, bytes]:
    """Read a frame of a stream, and its bytes.

    Raises:
        Malformed: It is something else, or too large.
    """
    line, body = _split(data)
    try:
        return _FRAMES.validate_json(line), body
    except ValidationError as error:
        raise malformed(error) from None


def _split(data: bytes) -> tuple[bytes, bytes]:
    line, _, body = data.partition(b"\n")
    if len(line) > MAX_LINE or len(body) > MAX_PIECE:
        raise Malformed("too_large", f"{len(line)} bytes of JSON and {len(body)} of data, which is too much")
    return line, body
