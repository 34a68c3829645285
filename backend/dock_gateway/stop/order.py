"""What a request to stop robots says. Nothing that cannot be read keeps a robot from being stopped."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from starlette.datastructures import QueryParams

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, MalformedRequest, got
from dock_gateway.http.principal import signed
from dock_gateway.http.requests import ROBOT_PATTERN, name_schema, read_name, read_object

log = logging.getLogger(__name__)

FIELDS = ("latch", "by")
MAX_NAME = 100
STOP_REQUEST = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "latch": {
            "type": "boolean",
            "description": "Whether goals are refused until the stop is released; true by default",
        },
        "by": name_schema(MAX_NAME) | {"type": ["string", "null"], "description": "Name of who stops the robot"},
        "robot": {
            "type": ["string", "null"],
            "description": "The robot, if it is not in the query",
            **ROBOT_PATTERN,
        },
    },
}
PREFER = [{"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=2"}]


@contextmanager
def noting(wrong: list[GatewayError]) -> Iterator[None]:
    """Append any error to `wrong`, and go on without that part of the request."""
    try:
        yield
    except GatewayError as error:
        wrong.append(error)
    except Exception:
        log.exception("a part of a stop could not be read")
        wrong.append(MalformedRequest("a part of the request could not be read", code="malformed_request"))


def warning(wrong: list[GatewayError]) -> dict[str, Any]:
    """Merge all errors into one problem, named after the first."""
    errors = [entry for error in wrong for entry in error.extra.get("errors", ())]
    detail = "; ".join(error.detail for error in wrong)
    return {**wrong[0].problem(), "detail": detail} | ({"errors": errors} if errors else {})


def read_stop(principal: Principal, value: object, wrong: list[GatewayError]) -> dict[str, Any]:
    """Return `latch` and `by` of a request to stop; the defaults, if it cannot be read.

    Args:
        principal: The user who stops robots; recorded if known, even if the rest of the request cannot be read.
        value: The decoded body, or the fields of a command.
        wrong: Errors found in the request. More are added.
    """
    how: dict[str, Any] = {"by": principal.name}
    with noting(wrong):
        how = _read_stop(read_object(signed(principal, value), *FIELDS))
    if wrong:
        log.warning("a stop is carried out although parts of the request are invalid: %s", warning(wrong)["detail"])
    return how


def _read_stop(fields: dict[str, Any]) -> dict[str, Any]:
    latch, by = fields.get("latch", True), fields.get("by")
    if not isinstance(latch, bool):
        raise InvalidField([FieldError("latch", "true or false", got(latch))])
    return {"latch": latch, "by": None if by is None else read_name(by, MAX_NAME)}


def read_robots(query: QueryParams, value: object, wrong: list[GatewayError]) -> list[str]:
    """Return the robots to stop (none is the configured one), and remove a name from the body.

    Raises:
        InvalidField: It is unclear which: the body names another than the query, or none is named and an unknown
            parameter may be a misspelt `robot`.
    """
    robots: list[Any] = query.getlist("robot")
    if isinstance(value, dict) and (isinstance(value.get("robot"), str) or not robots):
        named = value.pop("robot", None)
        if (named is not None and set(robots) - {named}) or not isinstance(named, str | None):
            raise InvalidField([FieldError("robot", "one robot, that of the query if it has one", got(named))])
        robots = [] if named is None else [named]
    unknown = [name for name in query if name != "robot"]
    if unknown:
        expected, detail = "robot and nothing else", "got an unknown parameter"
        error = InvalidField([FieldError(f"query.{name[:100]}", expected, detail) for name in unknown[:20]])
        if not robots:
            raise error
        wrong.append(error)
    return robots
