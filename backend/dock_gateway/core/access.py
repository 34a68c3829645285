"""Who uses the gateway, and what they may do. Plain data."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum


class Role(StrEnum):
    """A role, which says what a user may do. Each includes the ones before it."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    SUPERVISOR = "supervisor"
    ADMIN = "admin"

    def includes(self, other: "Role") -> bool:
        """Return whether this role allows everything that the other one does."""
        roles = list(Role)
        return roles.index(self) >= roles.index(other)


@dataclass(frozen=True)
class Token:
    """A token that a script or a person shows, as it is stored: without its secret.

    Attributes:
        name: Who uses it.
        role: What they may do.
        digest: SHA-256 of the secret, in hexadecimal digits.
        created_by: Who created it, if known.
        created_at: When that was.
        expires_at: Until when it is valid; None: until it is revoked.
        used_at: When it was used last, to the minute; None: never.
    """

    name: str
    role: Role
    digest: str
    created_by: str | None
    created_at: datetime
    expires_at: datetime | None
    used_at: datetime | None

    def valid(self, now: datetime) -> bool:
        """Return whether it has not expired."""
        return self.expires_at is None or now < self.expires_at


@dataclass(frozen=True)
class Principal:
    """Who makes a request.

    Attributes:
        name: As the token says; None where the gateway asks for no token.
        role: What they may do.
        token_id: The token; None where the gateway asks for none.
    """

    name: str | None
    role: Role
    token_id: str | None


# Everybody, where the gateway asks for no token.
ANYBODY = Principal(None, Role.ADMIN, None)
