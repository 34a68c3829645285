"""Declares on a function what the operation needs: role, scope, audit and quota. Each door to it needs the same."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from enum import Enum, auto
from typing import Any, Self, TypeVar

from starlette.routing import BaseRoute

from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role

READS = frozenset({"GET", "HEAD"})
F = TypeVar("F", bound=Callable[..., object])
Read = Callable[[Principal, object], Mapping[str, Any]]


class Trait(Enum):
    """What follows for every request or command of a scope."""

    ABOUT_ROBOTS = auto()  # another gateway may have to be asked: `ServedElsewhere`
    NAMED = auto()  # there may be none of that name; a robot need not be there, where its history is read
    TYPED = auto()  # it has a type of ROS, whose package may be missing


class Scope(Enum):
    """The subject of a request or a command, which the user's grant has to include.

    Attributes:
        traits: What follows from it.
    """

    traits: tuple[Trait, ...]

    def __new__(cls, value: str, *traits: Trait) -> Self:
        """Make a member of its value and its traits."""
        member = object.__new__(cls)
        member._value_ = value
        member.traits = traits
        return member

    ANY = "any"  # nothing that a grant is limited to
    LISTED = "listed"  # what the grant includes: the route leaves out the rest
    EVERY = "every"  # every robot
    ROBOT = "robot", Trait.ABOUT_ROBOTS  # the robot in `robot`; the configured one if none is named
    ROBOTS = "robots", Trait.ABOUT_ROBOTS  # the robot in `robot` and those below it; every robot if none is named
    DOCK = "dock", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED  # its docking action
    UNDOCK = "undock", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED  # its undocking action
    ACTION = "action", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED  # the action in `name`
    # The action in `action`, or the docking action of `robot`.
    NEW_GOAL = "new_goal", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED
    GOAL = "goal", Trait.ABOUT_ROBOTS, Trait.NAMED  # the action of the goal in `goal_id`
    ALERT = "alert", Trait.NAMED  # the robot of the alert in `alert_id`
    APPROVAL = "approval", Trait.NAMED  # the action of the goal that waits for approval, in `approval_id`
    TOPIC = "topic", Trait.NAMED, Trait.TYPED  # the topic in `name` or `topic`
    PUBLISHING = "publishing", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED  # the topic in `topic`, to publish on it
    LOOKED_AT = "looked_at", Trait.NAMED, Trait.TYPED  # the node in `node` or the service in `service`, to be shown
    SERVICE = "service", Trait.ABOUT_ROBOTS, Trait.NAMED, Trait.TYPED  # the service in `service`, which is called
    NODE = "node", Trait.ABOUT_ROBOTS, Trait.NAMED  # the node in `node`, whose parameters are set


class Audit(Enum):
    """Whether the audit log has a request or a command."""

    NEVER = auto()  # it changes nothing
    CHANGES = auto()  # unless it is a GET
    ALWAYS = auto()  # also a GET: it hands out much at once, or says who did what
    STORED_FIRST = auto()  # always, and its entry is stored before it is answered, if it succeeds


@dataclass(frozen=True)
class Operation:
    """The requirements of a request or a command.

    As a decorator, `@operation(role, scope)`, it declares them on the function, under the decorator of the route.

    Attributes:
        role: The role; None if it needs no login.
        scope: Its subject, which the user's grant has to include.
        audit: Whether the audit log has it.
        errors: Statuses of its errors, besides those that follow from what it is about and takes: see `http/route`.
        sends_goal: Whether it sends a goal, which counts towards the user's goals per minute.
        reads_body: Whether its endpoint reads the body itself. It is then authorized by its head alone.
        any_query: Whether a request may have query parameters that its endpoint does not have.
        stops: Whether it stops something: a body that it does not take is then not read, and never a reason to refuse.
        read: Reads the request of a command into its fields. None: the request itself has the fields.
    """

    role: Role | None
    scope: Scope
    audit: Audit = Audit.CHANGES
    _: KW_ONLY
    errors: Collection[int] = ()
    sends_goal: bool = False
    reads_body: bool = False
    any_query: bool = False
    stops: bool = False
    read: Read | None = None

    def audits(self, method: str) -> bool:
        """Whether the audit log has a request with this method."""
        return self.audit in (Audit.ALWAYS, Audit.STORED_FIRST) or (self.audit is Audit.CHANGES and method not in READS)

    def __call__(self, function: F) -> F:
        """Declare on an endpoint or a command that it needs this."""
        function.operation = self  # type: ignore[attr-defined]
        return function


operation = Operation


def public_operation(
    audit: Audit = Audit.CHANGES, *, errors: Collection[int] = (), any_query: bool = False
) -> Operation:
    """Declare that an endpoint needs no login: a health check, or the login itself."""
    return Operation(None, Scope.ANY, audit, errors=errors, any_query=any_query)


def carries_out(function: Callable[..., object], scope: Scope | None = None) -> Operation:
    """Declare that an endpoint or a command carries out an operation, and needs what that needs.

    Args:
        function: The operation.
        scope: Its subject, where this door names it by other fields than the operation does.
    """
    declared = operation_of(function)
    return declared if scope is None else replace(declared, scope=scope)


def find_operation(route: object) -> Operation | None:
    """Return what a route needs; None if it is not of the API, such as a file of the dashboard."""
    declared = getattr(getattr(route, "endpoint", None), "operation", None)
    return declared if isinstance(declared, Operation) else None


class BadRoute(TypeError):
    """The routes are such that no application can be made of them."""


class Undeclared(BadRoute):
    """An endpoint or a command does not say what it needs."""


class Unaudited(BadRoute):
    """A route may change something, and the audit log would not have it."""


class DuplicateRoute(BadRoute):
    """There is a route for this method and path already."""


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
        Undeclared: A route does not say what it needs.
        Unaudited: A route may change something that the audit log would not have.
    """
    for route in routes:
        declared = operation_of(getattr(route, "endpoint", route))
        if declared.audit is Audit.NEVER and (getattr(route, "methods", None) or set()) - READS:
            raise Unaudited(f"{getattr(route, 'path', route)} may change something: the audit log must have it")


def require_distinct(routes: Iterable[BaseRoute]) -> None:
    """Refuse a second route for a method and a path: it would never be asked, or in place of the first.

    Raises:
        DuplicateRoute: There is such a route.
    """
    seen: set[tuple[str, str]] = set()
    for route in routes:
        for method in getattr(route, "methods", None) or ():
            asked = (method, getattr(route, "path", ""))
            if asked in seen:
                raise DuplicateRoute(f"two routes are {' '.join(asked)}")
            seen.add(asked)
