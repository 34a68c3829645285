"""Refuses what a request has and its operation does not take: it must not be ignored when a robot moves."""

from collections.abc import Awaitable, Callable, Collection

from fastapi import Request
from starlette.requests import HTTPConnection

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.http.requests import read_body

# The headers by which a change depends on a version (RFC 9110, section 13.1).
CONDITIONS = ("If-Match", "If-None-Match")


def known_query(*names: str) -> Callable[[HTTPConnection], Awaitable[None]]:
    """Return a dependency that refuses query parameters other than these.

    A misspelt parameter, or one of another version, must not be ignored when a robot moves. Nor may a robot be named
    twice: only one of them would be meant.

    Raises:
        InvalidField: Lists the unknown parameters, or there is more than one robot.
    """

    async def check(connection: HTTPConnection) -> None:
        expected = f"one of {', '.join(names)}" if names else "no query parameters"
        unknown = [name for name in connection.query_params if name not in names]
        if unknown:
            raise InvalidField(
                [FieldError(name[:100], expected, "got an unknown parameter", "query") for name in unknown[:20]]
            )
        if (robots := len(connection.query_params.getlist("robot"))) > 1:
            raise InvalidField([FieldError("robot", "one robot", f"got {robots}", "query")])

    return check


async def no_body(request: Request) -> None:
    """Refuse a body. A robot that it names would be ignored, and every robot be meant.

    Raises:
        InvalidField: There is one.
        MalformedRequest: It is too large, too slow or cut off.
    """
    if raw := await read_body(request):
        expected = "no body: name a robot in the query, such as ?robot=/robot1"
        raise InvalidField([FieldError("", expected, f"got {len(raw)} bytes")])


def known_conditions(names: Collection[str]) -> Callable[[Request], Awaitable[None]]:
    """Return a dependency that refuses conditions on a version other than these: the change would not depend on them.

    Raises:
        InvalidField: Lists them.
    """

    async def check(request: Request) -> None:
        unknown = [name for name in CONDITIONS if name in request.headers and name not in names]
        if unknown:
            why = f"only {', '.join(names)} counts here" if names else "this has no versions here"
            raise InvalidField([FieldError(name, f"no {name}: {why}", "got one", "header") for name in unknown])

    return check
