"""Read requests: size-limited bodies, headers and parameters. What is not taken is refused: see `http/unexpected`."""

import asyncio
import re
import uuid
from http import HTTPStatus
from typing import Annotated, Any, Generic, TypeVar

from fastapi import Depends, Path, Query, Request
from pydantic import WithJsonSchema
from starlette.convertors import PathConvertor, register_url_convertor
from starlette.requests import ClientDisconnect
from starlette.responses import Response

from dock_gateway.core.cursor import Cursor, read_cursor
from dock_gateway.core.errors import FieldError, InvalidField, MalformedRequest, Place, got
from dock_gateway.core.goal import GoalStatus, encode
from dock_gateway.core.json_text import decode_json
from dock_gateway.core.namespace import NAMESPACE
from dock_gateway.http.parts import parts_of
from dock_gateway.setting_types import ROS_TOKEN
from dock_gateway.settings import Settings

ModelT = TypeVar("ModelT")

# The default content type of `curl -d` is accepted as JSON, too. OriginGuard keeps other origins from exploiting it.
JSON_TYPES = ("application/json", "application/x-www-form-urlencoded")
MAX_WAIT = 300.0
MAX_KEY = 200
MAX_TAG, MAX_GROUP = 30, 40  # characters
# Where the scope has the body once it was read.
BODY = "body"
MAX_DIGITS = 18  # enough for every number in a header
# A line of text: no control, bidirectional or invisible characters; not blank.
_UNSEEN = r"\x00-\x1f\x7f-\x9f\xad\u200b-\u200f\u2028-\u202f\u205f-\u206f\ufeff\ufff9-\uffff"
LINE_OF_TEXT = re.compile(rf"[^{_UNSEEN}]*[^\s{_UNSEEN}][^{_UNSEEN}]*")


async def read_json(request: Request, *, empty: Any = None, within: float | None = None) -> Any:
    """Return the decoded JSON body, or `empty` if there is none. `within` can shorten the timeout, in seconds.

    Raises:
        InvalidField: There is no body, and `empty` is None.
        MalformedRequest: The body is not JSON, too large, too slow or cut off, or has another content type.
    """
    raw = await read_body(request, within)
    if not raw:
        if empty is None:
            raise InvalidField([FieldError("", "an object, {} for the defaults", "got no body")])
        return empty
    encoding = request.headers.get("content-encoding", "identity").strip().lower()
    if encoding not in ("", "identity"):
        raise MalformedRequest(
            f"the body is encoded ({encoding[:60]}): send it as it is, without Content-Encoding",
            code="unsupported_media_type",
            status=HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
        )
    content_type = request.headers.get("content-type", JSON_TYPES[0]).partition(";")[0].strip().lower()
    if content_type not in JSON_TYPES and not content_type.endswith("+json"):
        raise MalformedRequest(
            f"the body is {content_type[:100]!r}; application/json is expected",
            code="unsupported_media_type",
            status=HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
        )
    return decode_json(raw, "the body")


async def read_body(request: Request, within: float | None = None) -> bytes:
    """Return the whole body. It is read once, and kept. `within` can shorten the timeout, in seconds.

    Raises:
        MalformedRequest: It is too large, too slow or cut off.
    """
    if BODY not in request.scope:
        empty = request.headers.get("content-length") == "0"
        request.scope[BODY] = b"" if empty else await _read_in_time(request, within)
    body: bytes = request.scope[BODY]
    return body


async def _read_in_time(request: Request, within: float | None) -> bytes:
    settings = parts_of(request)[Settings]
    timeout = settings.body_timeout if within is None else min(within, settings.body_timeout)
    try:
        async with asyncio.timeout(timeout):
            return await _read(request, settings.max_body_bytes)
    except TimeoutError:
        raise MalformedRequest(
            f"the body did not arrive within {timeout:g} s",
            code="request_timeout",
            status=HTTPStatus.REQUEST_TIMEOUT,
        ) from None
    except ClientDisconnect:
        raise MalformedRequest("the connection was closed before the body was complete") from None


async def _read(request: Request, limit: int) -> bytes:
    raw = bytearray()
    too_large = MalformedRequest(
        f"the body is larger than {limit} bytes",
        code="body_too_large",
        status=HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
    )
    if (read_digits(request.headers.get("content-length", "")) or 0) > limit:
        raise too_large
    async for chunk in request.stream():
        raw += chunk
        if len(raw) > limit:
            raise too_large
    return bytes(raw)


def read_object(value: object, *fields: str) -> dict[str, Any]:
    """Return a decoded body, which must be an object with no fields other than these.

    Raises:
        InvalidField: It is not.
    """
    expected = f"an object with {', '.join(fields)}"
    if not isinstance(value, dict):
        raise InvalidField([FieldError("", expected, "got something else")])
    unknown = [name for name in value if name not in fields]
    if unknown:
        raise InvalidField(
            [FieldError(name[:200], f"one of {', '.join(fields)}", "got an unknown field") for name in unknown[:20]]
        )
    return value


def is_name(text: str, longest: int) -> bool:
    """Return whether a text is a line of at most `longest` characters that can be seen."""
    return len(text) <= longest and LINE_OF_TEXT.fullmatch(text) is not None


def read_name(value: object, longest: int, path: str = "by") -> str:
    """Return a name, by default that of the requester in the field `by`, without surrounding spaces.

    Raises:
        InvalidField: It is not a name of at most `longest` characters.
    """
    if not isinstance(value, str) or not is_name(value, longest):
        raise InvalidField([FieldError(path, f"1 to {longest} characters, in one line", got(value))])
    return value.strip()


def name_schema(longest: int) -> dict[str, Any]:
    """Return the schema of such a name for the OpenAPI document."""
    return {"type": "string", "maxLength": longest, "pattern": f"^{LINE_OF_TEXT.pattern}$"}


def read_wait(request: Request) -> float:
    """Return the seconds to wait for the end of a goal, from `Prefer: wait=30`; 0 by default.

    Raises:
        InvalidField: It is not a number of seconds from 0 to 300.
    """
    for preference in request.headers.get("prefer", "").split(","):
        name, _, value = preference.partition("=")
        if name.strip().lower() != "wait":
            continue
        seconds = read_digits(value.partition(";")[0].strip().strip('"'))
        if seconds is None or seconds > MAX_WAIT:
            raise InvalidField(
                [FieldError("Prefer", f"wait=0 to wait={MAX_WAIT:.0f}", f"got {preference.strip()[:60]!r}", "header")]
            )
        return float(seconds)
    return 0.0


def read_digits(text: str) -> int | None:
    """Read a number from a header; None if it is not one. Digits beyond the first 18 are ignored."""
    return int(text[:MAX_DIGITS]) if text.isascii() and text.isdecimal() else None


def read_key(request: Request) -> str | None:
    """Return the Idempotency-Key header.

    Raises:
        InvalidField: It is not a key.
    """
    return check_key(request.headers.get("idempotency-key"), "Idempotency-Key", "header")


def check_key(key: str | None, path: str, place: Place = "body") -> str | None:
    """Check and return an idempotency key, which may be None.

    Raises:
        InvalidField: It is empty or too long, or has a NUL, which databases do not accept.
    """
    if key is not None and (not 0 < len(key) <= MAX_KEY or "\0" in key):
        raise InvalidField([FieldError(path, f"1 to {MAX_KEY} characters, without NUL", got(key), place)])
    return key


GOAL_ID = re.compile(r"[0-9A-Fa-f]{8}-?(?:[0-9A-Fa-f]{4}-?){3}[0-9A-Fa-f]{12}")


class GraphNameConvertor(PathConvertor):
    """Reads a name on the ROS graph from a path. Its leading slash may be there: `/actions/%2Ffibonacci`.

    It has none at its end: `/actions/` and `/actions/fibonacci/` are redirected, like every path that ends with one.
    """

    regex = ".*[^/]"

    def convert(self, value: str) -> str:
        """Return the name without its leading slash."""
        return value.removeprefix("/")


# Routes name it as `{name:graph_name}`. The check of a grant gets the same name as the route.
register_url_convertor("graph_name", GraphNameConvertor())

# A name on the ROS graph without its leading slash.
GraphName = Annotated[
    str,
    Path(
        description="The name on the ROS graph; its leading slash may be left out",
        json_schema_extra={"pattern": f"^/?{ROS_TOKEN.pattern}(?:/{ROS_TOKEN.pattern})*$"},
    ),
]


ROBOT_PATTERN = {"pattern": f"^{NAMESPACE.pattern}$"}
# What a request is about by its `robot`: `x-robot` of its operation, which the OpenAPI document has from here.
X_ROBOT = "x-robot"
ONE, ANY, BELOW = ({X_ROBOT: meaning} for meaning in ("configured", "all", "below"))
RobotQuery = Annotated[
    str | None,
    Query(
        description="Namespace of the robot, such as `/robot1`; by default that of the configured one",
        json_schema_extra={**ROBOT_PATTERN, **ONE},
    ),
]
AnyRobotQuery = Annotated[
    str | None,
    Query(
        description="Namespace of the robot, such as `/robot1`; by default all are meant",
        json_schema_extra={**ROBOT_PATTERN, **ANY},
    ),
]
BelowQuery = Annotated[
    str | None,
    Query(
        description="Namespace of the robot, such as `/robot1`: it and those below are meant; by default all",
        json_schema_extra={**ROBOT_PATTERN, **BELOW},
    ),
]
RobotsQuery = Annotated[
    list[Annotated[str, WithJsonSchema({"type": "string", **ROBOT_PATTERN})]] | None,
    Query(
        description="Namespaces of robots, such as `/robot1`: they and those below are meant; by default all",
        json_schema_extra=BELOW,
    ),
]
StatusQuery = Annotated[list[GoalStatus] | None, Query(description="Only goals in these states")]
LimitQuery = Annotated[int, Query(ge=1, le=500)]
CursorQuery = Annotated[str | None, Query(max_length=200, description="`next_cursor` of the previous page")]


def end_of_page(cursor: str | None) -> Cursor | None:
    """Return where the page before ended; None if this is the first.

    Raises:
        InvalidField: The cursor is none.
    """
    try:
        return None if cursor is None else read_cursor(cursor)
    except ValueError as error:
        raise InvalidField([FieldError("cursor", str(error), got(cursor), "query")]) from None


class Answer(Response, Generic[ModelT]):
    """A JSON response. The return annotation of a route, `Answer[Model]`, says what it describes."""

    media_type = "application/json"

    def render(self, content: bytes) -> bytes:
        """Return the body: for people who read it in a terminal, it ends with a newline."""
        return content + b"\n"


def json_response(document: object, status: int = 200, headers: dict[str, str] | None = None) -> Answer[Any]:
    """Return a JSON response, encoded as everywhere in the gateway."""
    return Answer(encode(document), status, headers)


# `responses=` of a list that a stream can go on from.
WITH_POSITION: dict[int | str, dict[str, Any]] = {
    200: {
        "headers": {
            "Event-Id": {
                "description": "The last event before the list was read: `after` of a stream that goes on from it",
                "schema": {"type": "string"},
            }
        }
    }
}


def list_response(document: object, position: str) -> Answer[Any]:
    """Return the response of a list. A stream from the position misses no change of it."""
    return json_response(document, headers={"Event-Id": position})


def is_known_tag(condition: str | None, tag: str) -> bool:
    """Whether `If-None-Match` names the tag (RFC 9110, section 13.1.2)."""
    known = [part.strip().removeprefix("W/") for part in (condition or "").split(",")]
    return tag in known or known == ["*"]


def read_goal_id(goal_id: str, place: Place = "query") -> str:
    """Return a goal id in its canonical form. `ros2 action send_goal` prints it without hyphens.

    Raises:
        InvalidField: It is not a UUID.
    """
    if not GOAL_ID.fullmatch(goal_id):
        raise InvalidField([FieldError("goal_id", "a UUID", f"got {goal_id[:60]!r}", place)])
    return str(uuid.UUID(goal_id))


async def _goal_id_in_path(goal_id: Annotated[str, Path(json_schema_extra={"pattern": f"^{GOAL_ID.pattern}$"})]) -> str:
    return read_goal_id(goal_id, "path")


GoalId = Annotated[str, Depends(_goal_id_in_path)]


# An id that people choose.
SLUG = re.compile(r"[a-z0-9](?:[a-z0-9-]{0,38}[a-z0-9])?")
SLUG_IN_PATH = Path(
    description="Lower-case letters, digits and hyphens, up to 40", json_schema_extra={"pattern": f"^{SLUG.pattern}$"}
)


def read_slug(value: str, path: str) -> str:
    """Return an id that people choose.

    Raises:
        InvalidField: It is not one.
    """
    if not SLUG.fullmatch(value):
        raise InvalidField(
            [FieldError(path, "up to 40 lower-case letters, digits and hyphens between them", got(value), "path")]
        )
    return value
