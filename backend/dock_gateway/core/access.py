"""Who uses the gateway, and what they may do. Plain data."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from dock_gateway.core.grant import UNLIMITED, Grant, Role


class Kind(StrEnum):
    """What shows who makes a request."""

    TOKEN = "token"  # noqa: S105 - it is not one
    USER = "user"
    SERVICE = "service"
    ANYBODY = "anybody"


@dataclass(frozen=True)
class Token:
    """A token that a script or a person shows, as it is stored: without its secret.

    Attributes:
        name: Who uses it.
        role: What they may do.
        robots, actions, topics: With what, as in `Grant`.
        digest: SHA-256 of the secret, in hexadecimal digits.
        created_by: Who created it, if known.
        created_at: When that was.
        expires_at: Until when it is valid; None: until it is revoked.
        used_at: When it was used last, to the minute; None: never.
    """

    name: str
    role: Role
    robots: tuple[str, ...]
    actions: tuple[str, ...]
    topics: tuple[str, ...]
    digest: str
    created_by: str | None
    created_at: datetime
    expires_at: datetime | None
    used_at: datetime | None

    @property
    def grant(self) -> Grant:
        """What its user may do."""
        return Grant(self.role, self.robots, self.actions, self.topics)

    def valid(self, now: datetime) -> bool:
        """Return whether it has not expired."""
        return self.expires_at is None or now < self.expires_at


@dataclass(frozen=True)
class Principal:
    """Who makes a request.

    Attributes:
        name: Their name; None where the gateway does not ask who it is.
        kind: What shows who it is.
        grant: What they may do.
        credential: Id of the token; None where the gateway does not ask for one.
    """

    name: str | None
    kind: Kind
    grant: Grant
    credential: str | None


# Everybody, where the gateway does not ask who it is.
ANYBODY = Principal(None, Kind.ANYBODY, UNLIMITED, None)
