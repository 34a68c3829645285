"""Declares on a function what the operation needs: role, scope, audit and quota. Each door to it needs the same."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import Any, TypeVar

from starlette.routing import BaseRoute

from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role

READS = frozenset({"GET", "HEAD"})
F = TypeVar("F", bound=Callable[..., object])
Read = Callable[[Principal, object], Mapping[str, Any]]


class Scope(Enum):
    """The subject of a request or a command, which the user's grant has to include."""

    ANY = auto()  # nothing that a grant is limited to
    LISTED = auto()  # what the grant includes: the route leaves out the rest
    ROBOT = auto()  # the robot in `robot`; the configured one if none is named
    ROBOTS = auto()  # the robot in `robot` and those below it; every robot if none is named
    DOCK = auto()  # its docking action
    UNDOCK = auto()  # its undocking action
    ACTION = auto()  # the action in `name`
    GOAL = auto()  # the action of the goal in `goal_id`
    NEW_GOAL = auto()  # the action in `action`, or the docking action of `robot`
    ALERT = auto()  # the robot of the alert in `alert_id`
    APPROVAL = auto()  # the action of the goal that waits for approval, in `approval_id`
    TOPIC = auto()  # the topic in `name` or `topic`
    LOOKED_AT = auto()  # the node in `node` or the service in `service`, which are only looked at
    SERVICE = auto()  # the service in `service`, which is called
    NODE = auto()  # the node in `node`, whose parameters are set
    PUBLISHING = auto()  # the topic in `topic`, on which something is published
    EVERY = auto()  # every robot


# What another gateway may have to be asked for: `ServedElsewhere`.
ABOUT_ROBOTS = frozenset(
    {
        Scope.ROBOT,
        Scope.ROBOTS,
        Scope.DOCK,
        Scope.UNDOCK,
        Scope.ACTION,
        Scope.GOAL,
        Scope.NEW_GOAL,
        Scope.SERVICE,
        Scope.NODE,
        Scope.PUBLISHING,
    }
)

# What is named, so that there may be none of that name. A robot need not be there, where its history is read.
NAMED = frozenset(
    {
        Scope.DOCK,
        Scope.UNDOCK,
        Scope.ACTION,
        Scope.GOAL,
        Scope.NEW_GOAL,
        Scope.ALERT,
        Scope.APPROVAL,
        Scope.TOPIC,
        Scope.LOOKED_AT,
        Scope.SERVICE,
        Scope.NODE,
        Scope.PUBLISHING,
    }
)


# What has a type of ROS, whose package may be missing.
TYPED = frozenset(
    {
        Scope.DOCK,
        Scope.UNDOCK,
        Scope.ACTION,
        Scope.NEW_GOAL,
        Scope.TOPIC,
        Scope.LOOKED_AT,
        Scope.SERVICE,
        Scope.PUBLISHING,
    }
)


class Audit(Enum):
    """Whether the audit log has a request or a command."""

    NEVER = auto()  # it changes nothing
    CHANGES = auto()  # unless it is a GET
    ALWAYS = auto()  # also a GET: it hands out much at once, or says who did what
    STORED_FIRST = auto()  # always, and its entry is stored before it is answered, if it succeeds


@dataclass(frozen=True)
class Operation:
    """The requirements of a request or a command.

    Attributes:
        role: The role; None if it needs no login.
        scope: Its subject, which the user's grant has to include.
        audit: Whether the audit log has it.
        errors: Statuses of its errors, besides those that follow from what it is about and takes: see `http/route`.
        sends_goal: Whether it sends a goal, which counts towards the user's goals per minute.
        reads_body: Whether its endpoint reads the body itself. It is then authorized by its head alone.
        any_query: Whether a request may have query parameters that its endpoint does not have.
        read: Reads the request of a command into its fields. None: the request itself has the fields.
    """

    role: Role | None
    scope: Scope
    audit: Audit = Audit.CHANGES
    errors: frozenset[int] = frozenset()
    sends_goal: bool = False
    reads_body: bool = False
    any_query: bool = False
    read: Read | None = None

    def audits(self, method: str) -> bool:
        """Whether the audit log has a request with this method."""
        return self.audit in (Audit.ALWAYS, Audit.STORED_FIRST) or (self.audit is Audit.CHANGES and method not in READS)


def operation(
    role: Role,
    scope: Scope,
    audit: Audit = Audit.CHANGES,
    *,
    errors: Iterable[int] = (),
    sends_goal: bool = False,
    reads_body: bool = False,
    any_query: bool = False,
    read: Read | None = None,
) -> Callable[[F], F]:
    """Declare what an endpoint or a command needs. It stands under the decorator of the route.

    Args:
        role: The role that it needs.
        scope: Its subject, which the user's grant has to include.
        audit: Whether the audit log has it.
        errors: Statuses of its errors, besides those that follow from the rest.
        sends_goal: Whether it sends a goal.
        reads_body: Whether the endpoint reads the body itself.
        any_query: Whether a request may have query parameters that the endpoint does not have.
        read: Reads the request of a command into its fields. None: the request itself has the fields.
    """
    return _declare(Operation(role, scope, audit, frozenset(errors), sends_goal, reads_body, any_query, read))


def public_operation(
    audit: Audit = Audit.CHANGES, *, errors: Iterable[int] = (), any_query: bool = False
) -> Callable[[F], F]:
    """Declare that an endpoint needs no login: a health check, or the login itself."""
    return _declare(Operation(None, Scope.ANY, audit, frozenset(errors), any_query=any_query))


def carries_out(function: Callable[..., object], scope: Scope | None = None) -> Callable[[F], F]:
    """Declare that an endpoint or a command carries out an operation, and needs what that needs.

    Args:
        function: The operation.
        scope: Its subject, where this door names it by other fields than the operation does.
    """
    declared = operation_of(function)
    return _declare(declared if scope is None else replace(declared, scope=scope))


def _declare(declared: Operation) -> Callable[[F], F]:
    def declare(function: F) -> F:
        function.operation = declared  # type: ignore[attr-defined]
        return function

    return declare


def find_operation(route: object) -> Operation | None:
    """Return what a route needs; None if it is not of the API, such as a file of the dashboard."""
    declared = getattr(getattr(route, "endpoint", None), "operation", None)
    return declared if isinstance(declared, Operation) else None


class Undeclared(TypeError):
    """An endpoint or a command does not say what it needs."""


def operation_of(function: object) -> Operation:
    """Return what an endpoint or a command needs.

    Raises:
        Undeclared: It does not say so.
    """
    declared = getattr(function, "operation", None)
    if not isinstance(declared, Operation):
        name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', function)}"
        raise Undeclared(f"{name} does not say which role it needs: put @operation(role, scope) above it")
    return declared


def require_declared(routes: Iterable[BaseRoute]) -> None:
    """Refuse routes that do not say what they need, and changes that the audit log would not have.

    Raises:
        Undeclared: There is such a route.
    """
    for route in routes:
        declared = operation_of(getattr(route, "endpoint", route))
        if declared.audit is Audit.NEVER and (getattr(route, "methods", None) or set()) - READS:
            raise Undeclared(f"{getattr(route, 'path', route)} may change something: the audit log must have it")


def require_distinct(routes: Iterable[BaseRoute]) -> None:
    """Refuse a second route for a method and a path: it would never be asked, or in place of the first.

    Raises:
        Undeclared: There is such a route.
    """
    seen: set[tuple[str, str]] = set()
    for route in routes:
        for method in getattr(route, "methods", None) or ():
            asked = (method, getattr(route, "path", ""))
            if asked in seen:
                raise Undeclared(f"two routes are {' '.join(asked)}")
            seen.add(asked)
