"""Reads a request to stop robots, at every door. That never fails: what is unclear stops all robots."""

import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from starlette.datastructures import QueryParams

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, MalformedRequest, got
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import ALL_ROBOTS, is_namespace, normalize_namespace
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.principal import signed
from dock_gateway.http.requests import ROBOT_PATTERN, name_schema, read_name, read_object

log = logging.getLogger(__name__)

MAX_NAME = 100
# Robots that a request can name, and errors that its warning lists.
MAX_ROBOTS, MAX_ERRORS = 1000, 20
FIELDS = ("latch", "by", "robot")
# Protocols that have services have the stop as this one.
STOP_SERVICE = "/dock_gateway/stop"
UNCLEAR = "All robots are stopped, as it is not clear which are meant."
ROBOT = {"type": "string", **ROBOT_PATTERN}
STOP_REQUEST = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "latch": {
            "type": "boolean",
            "description": "Whether goals are refused until the stop is released; true by default",
        },
        "by": name_schema(MAX_NAME) | {"type": ["string", "null"], "description": "Name of who stops the robots"},
        "robot": {
            "anyOf": [ROBOT, {"type": "array", "items": ROBOT}, {"type": "null"}],
            "description": "The robot, or several; all robots by default",
        },
    },
}
PREFER = [{"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=2"}]


@dataclass(frozen=True)
class StopOrder:
    """The meaning of a request to stop robots.

    Attributes:
        robots: Namespaces of the robots; those below them are meant, too. `/` is every robot.
        latch: Whether goals are refused until the stop is released.
        by: Who stops them, if known.
        wrong: What could not be understood.
        unclear: Whether all robots are meant because it is not clear which.
    """

    robots: tuple[str, ...] = (ALL_ROBOTS,)
    latch: bool = True
    by: str | None = None
    wrong: tuple[GatewayError, ...] = ()
    unclear: bool = False

    def warning(self, *others: GatewayError) -> dict[str, Any] | None:
        """Return what could not be understood, and other errors before it, as one problem named after the first."""
        wrong = (*others, *self.wrong)
        if not wrong:
            return None
        errors = [entry for error in wrong for entry in error.extra.get("errors", ())][:MAX_ERRORS]
        detail = "; ".join(error.detail for error in wrong) + (f". {UNCLEAR}" if self.unclear else "")
        return {**wrong[0].problem(), "detail": detail} | ({"errors": errors} if errors else {})


def read_order(
    principal: Principal, request: object, *, query: QueryParams | None = None, wrong: Iterable[GatewayError] = ()
) -> StopOrder:
    """Return what a request to stop robots means. Never fails.

    Names of robots that are understood are those to stop. If none is given, or one of them is not understood, all
    robots are meant. If anything is not understood, the stop is latched.

    Args:
        principal: The user who stops robots; recorded if known, even if the rest of the request cannot be read.
        request: The decoded body, or the fields of a command; an error if it could not be read.
        query: The query of the request, where `robot` may be repeated.
        wrong: Errors already found in the request.
    """
    reader = _Reader()
    with noting(reader.wrong):
        reader.read_query(query)
    with noting(reader.wrong):
        reader.read_fields(signed(principal, request))
    with noting(reader.wrong):
        reader.read_robots()
    order = StopOrder(
        reader.robots or (ALL_ROBOTS,),
        reader.latch or bool(reader.wrong),
        principal.name if reader.by is None else reader.by,
        (*wrong, *reader.wrong),
        reader.unclear and not reader.robots,
    )
    if (problem := order.warning()) is not None:
        log.warning("a stop is carried out although parts of the request are invalid: %s", problem["detail"])
    return order


def is_stop_service(name: object) -> bool:
    """Return whether a service is the one that stops robots, however its name is written."""
    return isinstance(name, str) and "/".join(filter(None, f"{name}".strip().lower().split("/"))) == STOP_SERVICE[1:]


def says(message: bytes | str, name: str, value: str) -> bool:
    """Return whether a message that cannot be decoded has a field, as one that is nested too deeply may have."""
    text = message if isinstance(message, str) else message.decode(errors="replace")
    return re.search(rf'"{name}"\s*:\s*"{re.escape(value)}"', text) is not None


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


class _Reader:
    """Reads the parts of one request, each by itself: one that is unclear spoils no other.

    Attributes:
        wrong: What could not be understood.
        unclear: Whether some of that may have named robots.
    """

    def __init__(self) -> None:
        self.wrong: list[GatewayError] = []
        self.unclear = False
        self.robots: tuple[str, ...] = ()
        self.latch = True
        self.by: str | None = None
        self._named: list[object] = []

    def read_query(self, query: QueryParams | None) -> None:
        self._named += [] if query is None else query.getlist("robot")
        unknown = [name for name in dict.fromkeys(query or ()) if name != "robot"]
        if unknown:
            self.unclear = True
            expected, detail = "robot and nothing else", "got an unknown parameter"
            raise InvalidField([FieldError(name[:100], expected, detail, "query") for name in unknown[:MAX_ERRORS]])

    def read_fields(self, request: object) -> None:
        if isinstance(request, Mapping):
            robot = request.get("robot")
            self._named += robot if isinstance(robot, list) else [robot]
            with noting(self.wrong):
                self.latch = _read_latch(request.get("latch", True))
            with noting(self.wrong):
                self.by = None if (by := request.get("by")) is None else read_name(by, MAX_NAME)
        self.unclear = self.unclear or not isinstance(request, dict) or bool(request.keys() - set(FIELDS))
        if isinstance(request, GatewayError):
            raise request
        read_object(request, *FIELDS)

    def read_robots(self) -> None:
        named = [name for name in self._named if name is not None]
        self.unclear = self.unclear or bool(named)
        robots = dict.fromkeys(map(_read_robot, named[:MAX_ROBOTS]))
        if len(named) > MAX_ROBOTS:
            raise InvalidField([FieldError("robot", f"at most {MAX_ROBOTS} robots", f"got {len(named)}")])
        self.robots = tuple(robots)


def _read_robot(name: object) -> str:
    # A robot that was to stop must not go on over a slash: `robot1` can only be `/robot1`.
    stripped = name.strip() if isinstance(name, str) else ""
    if not stripped or not is_namespace(text := normalize_namespace(stripped)):
        raise InvalidField([FieldError("robot", "a robot such as /robot1, or a list of them", got(name))])
    return text


def _read_latch(latch: object) -> bool:
    if not isinstance(latch, bool):
        raise InvalidField([FieldError("latch", "true or false", got(latch))])
    return latch


def _read(principal: Principal, request: object) -> Mapping[str, Any]:
    """Return the fields of the command: `robot` for the audit log, and the order."""
    order = read_order(principal, request)
    return {"robot": order.robots, "order": order}


# Declared once: each door's function that stops robots, or releases a stop, carries it.
stops_robots = operation(Role.VIEWER, Scope.ANY, reads_body=True, any_query=True, stops=True, read=_read)
releases_stop = operation(Role.SUPERVISOR, Scope.ROBOTS, Audit.STORED_FIRST, errors=(404,))
