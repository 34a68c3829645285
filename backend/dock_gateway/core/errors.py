"""All refusals and failures, each with a stable `code`: core/error_codes.py has them with their statuses.

The core raises these; `http/problems.py` turns them into problem+json, streams into a denial with the same body.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from http import HTTPStatus
from typing import Any, Literal

Place = Literal["body", "query", "path", "header", "cookie"]

# Characters of a sentence, which may repeat what a client has sent.
MAX_DETAIL = 8000


@dataclass(frozen=True)
class FieldError:
    """One invalid field: its dotted path, what was expected, what was received, and where in the request it is."""

    path: str
    expected: str
    detail: str
    place: Place = "body"

    def __str__(self) -> str:
        return f"{self.path or 'body'}: expected {self.expected}, {self.detail}"

    def document(self) -> dict[str, str]:
        """Return it as it is in a problem document."""
        return {"in": self.place, "path": self.path, "expected": self.expected, "detail": self.detail}


# What JSON calls them.
_WORDS = {None: "null", True: "true", False: "false"}


def got(value: object, longest: int = 40) -> str:
    """Describe the received value, for `FieldError.detail`. JSON may be nested deeper than `repr` can follow."""
    if value is None or isinstance(value, bool):
        return f"got {_WORDS[value]}"
    try:
        text = repr(value)
    except RecursionError:
        text = f"something nested too deeply, in {type(value).__name__}"
    return f"got {text[:longest]}"


class GatewayError(Exception):
    """A refusal or a failure that is reported to the caller.

    Args:
        detail: A human-readable sentence.
        code: A stable machine-readable name; each class has a default.
        extra: Further members of the problem document, such as `goal_id`.
    """

    status = HTTPStatus.INTERNAL_SERVER_ERROR
    code = "internal_error"

    def __init__(self, detail: str, *, code: str | None = None, status: HTTPStatus | None = None, **extra: Any) -> None:
        detail = detail if len(detail) <= MAX_DETAIL else f"{detail[:MAX_DETAIL]}…"
        super().__init__(detail)
        self.detail = detail
        self.code = code or self.code
        self.status = status or self.status
        self.extra = extra

    def problem(self) -> dict[str, Any]:
        """Return the RFC 9457 problem document."""
        return {
            "type": "about:blank",
            "title": self.code.replace("_", " ").capitalize(),
            "status": int(self.status),
            "code": self.code,
            "detail": self.detail,
            **self.extra,
        }


class MalformedRequest(GatewayError):
    """The request could not be read."""

    status = HTTPStatus.BAD_REQUEST
    code = "malformed_json"


class InvalidField(GatewayError):
    """The request was read, but some of its fields are invalid."""

    status = HTTPStatus.UNPROCESSABLE_ENTITY
    code = "invalid_field"

    def __init__(self, errors: Sequence[FieldError]) -> None:
        self.errors = errors
        super().__init__(
            "; ".join(map(str, errors)),
            errors=[error.document() for error in errors],
        )


@contextmanager
def fields_of_a_message(path: str = "") -> Iterator[None]:
    """Say of invalid fields that they are in a message, below a path: it also has what is a query in REST."""
    try:
        yield
    except InvalidField as error:
        paths = (".".join(filter(None, (path, each.path))) for each in error.errors)
        errors = [replace(each, path=below, place="body") for each, below in zip(error.errors, paths, strict=True)]
        raise InvalidField(errors) from error.__cause__


class NotAuthenticated(GatewayError):
    """The request does not say who makes it, or its token or login is not valid."""

    status = HTTPStatus.UNAUTHORIZED
    code = "not_authenticated"


class NotAllowed(GatewayError):
    """The request comes from a page of another origin, names a host that is not ours, or needs another role."""

    status = HTTPStatus.FORBIDDEN
    code = "origin_not_allowed"


def use_other_request(detail: str, use: str) -> NotAllowed:
    """Return the error that something is done by another request; `use` is its method and its path."""
    return NotAllowed(f"{detail}: use {use}", code="use_other_request", use=use)


def not_covered(about: str) -> NotAllowed:
    """Return the error that something lies beyond a grant."""
    return NotAllowed(f"your access does not include {about}", code="not_allowed")


class NotFound(GatewayError):
    """Nothing has that name."""

    status = HTTPStatus.NOT_FOUND
    code = "not_found"


class Conflict(GatewayError):
    """The state of a goal or of the action server does not allow the request."""

    status = HTTPStatus.CONFLICT
    code = "goal_rejected"


class DockOccupied(Conflict):
    """Another robot has the dock. The same goal may be sent later: what sends goals by itself waits for that.

    `wait_at` says where, if that has a place: `frame`, `x` and `y` in metres, and `yaw` in radians.
    """

    code = "dock_occupied"


def is_by_stop(error: GatewayError) -> bool:
    """Return whether a goal was not sent as its robot is stopped, or was meanwhile."""
    return error.code in ("stop_latched", "stopped")


def limit_reached(limit: int, what: str) -> Conflict:
    """Return the error that no more can be stored: `limit` is how many of `what` (a plural) there may be."""
    return Conflict(f"there are {limit} {what}; remove one first", code="limit_reached", limit=limit)


class ChangedMeanwhile(GatewayError):
    """A change depends on a version, and there is another one now."""

    status = HTTPStatus.PRECONDITION_FAILED
    code = "changed_meanwhile"


class ServedElsewhere(GatewayError):
    """Another gateway serves the robot."""

    status = HTTPStatus.MISDIRECTED_REQUEST
    code = "served_elsewhere"


class TooManyRequests(GatewayError):
    """A queue is full, or too many logins have failed."""

    status = HTTPStatus.TOO_MANY_REQUESTS
    code = "too_many_requests"


class NotInstalled(GatewayError):
    """The request needs something that is not installed: to try again does not help."""

    status = HTTPStatus.NOT_IMPLEMENTED
    code = "interface_not_installed"


class Unavailable(GatewayError):
    """A required part is not available now. The same request may succeed later."""

    status = HTTPStatus.SERVICE_UNAVAILABLE
    code = "action_server_unavailable"


class ServerTimeout(GatewayError):
    """The action server did not answer in time."""

    status = HTTPStatus.GATEWAY_TIMEOUT
    code = "action_server_timeout"
