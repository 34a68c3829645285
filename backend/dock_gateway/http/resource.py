"""What several people may change at the same time: it has an entity tag, and requests may depend on that.

`GET` of one, and a `PUT` of it, answer with the header `ETag`, which is the field `etag` of the document, also in a
list. With `If-Match`, a change is refused (`412 changed_meanwhile`) if someone else has changed it meanwhile. Without,
it replaces whatever is there.
"""

import re
from collections.abc import Awaitable, Iterable, Mapping
from contextlib import suppress
from typing import Annotated, Any

from fastapi import Depends, Header
from pydantic import Field
from pydantic.json_schema import SkipJsonSchema
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, NotFound, got
from dock_gateway.core.goal import encode
from dock_gateway.core.versions import EXISTING, Condition
from dock_gateway.http.requests import Answer, ModelT
from dock_gateway.http.schema import Schema

# Entity tags in a header. `W/` is what a proxy that compresses answers makes of a tag.
TAGS = re.compile(r'^[ \t]*(?:\*|(?:W/)?"[!#-~]*"(?:[ \t]*,[ \t]*(?:W/)?"[!#-~]*")*)[ \t]*$')
TAG = re.compile(r'"[^"]*"|\*')
ETAG_HEADER = {"ETag": {"description": "The version, for `If-Match`", "schema": {"type": "string"}}}
LOCATION_HEADER = {"Location": {"description": "Its path", "schema": {"type": "string"}}}


class Versioned(Schema):
    """Something that has versions."""

    etag: Annotated[str, Field(description="The version, as in the header `ETag`: send it as `If-Match`")]


class Item(Answer[ModelT]):
    """A JSON response about something that has versions. `Item[Model]` declares its headers, too."""


def item_response(
    document: Mapping[str, Any], new_at: str | None = None, headers: Mapping[str, str] | None = None
) -> Item[Any]:
    """Return the response about something that has versions.

    Args:
        document: The document, with its `etag`.
        new_at: Its path, if it was created by this request: the status is then 201.
        headers: Further headers.
    """
    location = {} if new_at is None else {"Location": new_at}
    status = 200 if new_at is None else 201
    return Item(encode(document), status, {"ETag": document["etag"], **location, **(headers or {})})


async def removed(removal: Awaitable[object]) -> Response:
    """Remove something, and return the response, which is the same if there is no such thing."""
    with suppress(NotFound):
        await removal
    return Response(status_code=204)


IfMatch = Annotated[
    str | SkipJsonSchema[None],
    Header(
        alias="If-Match",
        description="Entity tags: change it only if its version is one of these; `*`: if it exists",
        json_schema_extra={"pattern": TAGS.pattern},
    ),
]
IfNoneMatch = Annotated[
    str | SkipJsonSchema[None],
    Header(alias="If-None-Match", description="`*`: only if there is none yet", json_schema_extra={"pattern": r"^\*$"}),
]


async def read_change(if_match: IfMatch = None) -> Condition:
    """Return the condition of a change.

    Raises:
        InvalidField: The header is not a list of entity tags.
    """
    return Condition(_read_tags(if_match))


async def read_write(if_match: IfMatch = None, if_none_match: IfNoneMatch = None) -> Condition:
    """Return the condition of a write, which may create something.

    Raises:
        InvalidField: A header is not what it should be.
    """
    if if_none_match is not None and if_none_match.strip() != EXISTING:
        raise InvalidField([FieldError("If-None-Match", "*", got(if_none_match), "header")])
    return Condition(_read_tags(if_match), if_none_match is not None)


def _read_tags(header: str | None) -> frozenset[str] | None:
    if header is None:
        return None
    if not TAGS.fullmatch(header):
        raise InvalidField([FieldError("If-Match", 'entity tags, such as "9f2c", or *', got(header), "header")])
    return frozenset(TAG.findall(header))


ChangeCondition = Annotated[Condition, Depends(read_change)]
WriteCondition = Annotated[Condition, Depends(read_write)]
# Of what is there before it is set, too, so that no write creates it.
SetCondition = Annotated[Condition, Depends(read_write), "it is there, set or not"]


def described(model: type, *, status: int, creates: bool) -> dict[int | str, dict[str, Any]]:
    """Return the `responses=` of a route that answers with an item.

    Args:
        model: What it describes.
        status: Its status.
        creates: Whether it answers with 201 if it has created one.
    """
    new = {"headers": ETAG_HEADER | LOCATION_HEADER}
    answers: dict[int | str, dict[str, Any]] = {status: new if status == 201 else {"headers": ETAG_HEADER}}
    return answers | ({201: {"description": "It is new", "model": model} | new} if creates else {})


def conditions_of(calls: Iterable[object]) -> tuple[str, ...]:
    """Return the headers of the conditions that the dependencies of a route read."""
    read: dict[object, tuple[str, ...]] = {read_change: ("If-Match",), read_write: ("If-Match", "If-None-Match")}
    return next((read[call] for call in calls if call in read), ())
