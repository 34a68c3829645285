"""Users of the gateway and their grants. Plain data."""

import hashlib
import json
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from enum import StrEnum

from dock_gateway.core.grant import UNLIMITED, Grant, Role

# Where the scope of a request that another program forwards has who makes it.
FORWARDED = "forwarded"
# The name of who forwards requests of others without their names, and what the names of those others begin with.
FORWARDER = "hub"
OF_FORWARDER = "hub:"
# Time after which a session that is not used ends.
IDLE = timedelta(days=7)


class PrincipalKind(StrEnum):
    """The credential of a request."""

    TOKEN = "token"  # noqa: S105 - it is not one
    USER = "user"
    PERSON = "person"
    SERVICE = "service"
    FORWARDED = "hub"
    ANYBODY = "anybody"


@dataclass(frozen=True)
class Token:
    """A token that a script or a person shows, as it is stored: without its secret.

    Attributes:
        name: Its user.
        role: Role of the user.
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
        """The grant of its user."""
        return Grant(self.role, self.robots, self.actions, self.topics)

    def valid(self, now: datetime) -> bool:
        """Return whether it has not expired."""
        return self.expires_at is None or now < self.expires_at


@dataclass(frozen=True)
class User:
    """A person who logs in with a name and a password, as stored.

    Attributes:
        role: What they may do.
        robots, actions, topics: With what, as in `Grant`.
        password: The Argon2 hash of their password.
        era: A random text, which is new when all their sessions are to end.
        disabled: Whether they can log in no longer.
        created_by: Who added them, if known.
        created_at: When that was.
        logged_in_at: When they logged in last; None: never.
    """

    role: Role
    robots: tuple[str, ...]
    actions: tuple[str, ...]
    topics: tuple[str, ...]
    password: str
    era: str
    disabled: bool
    created_by: str | None
    created_at: datetime
    logged_in_at: datetime | None

    @property
    def grant(self) -> Grant:
        """The grant of the user."""
        return Grant(self.role, self.robots, self.actions, self.topics)


@dataclass(frozen=True)
class Session:
    """The login of a user in one browser, as stored: without its secret.

    Attributes:
        user: The user's name.
        era: The user's era at the login.
        digest: SHA-256 of the secret, in hexadecimal digits.
        created_at: When the user logged in.
        expires_at: When it ends at the latest.
        used_at: When it was used last, to the minute.
    """

    user: str
    era: str
    digest: str
    created_at: datetime
    expires_at: datetime
    used_at: datetime

    def valid(self, user: User | None, now: datetime) -> bool:
        """Return whether it has not ended.

        Args:
            user: Its user as they are now; None if they were removed.
            now: The time.
        """
        current = user is not None and not user.disabled and user.era == self.era
        return current and now < self.expires_at and now < self.used_at + IDLE


@dataclass(frozen=True)
class Principal:
    """The user or program that makes a request.

    Attributes:
        name: Their name; None where the gateway does not ask who it is.
        kind: The kind of credential.
        grant: Their grant.
        credential: Id of the token, the session, or the key that signed it; None where the gateway asks for none.
        expires_at: Until when the access token of a service is valid.
        key: Thumbprint of the provider's key that has signed it.
        client: The agent's program, as it calls itself.
        login: Who has logged in, if an agent acts for them.
        address: Where no one logs in, the address of the client, by which it has a share of its own (`http.quotas`).
    """

    name: str | None
    kind: PrincipalKind
    grant: Grant
    credential: str | None
    expires_at: datetime | None = None
    key: str | None = None
    client: str | None = None
    login: "Principal | None" = None
    address: str = ""

    def as_agent(self, client: str) -> "Principal":
        """Return an agent that acts for them: with their name and limits, and at most the role `agent`."""
        role = min(self.grant.role, Role.AGENT, key=list(Role).index)
        return replace(self, grant=replace(self.grant, role=role), client=client, login=self)

    def own(self, idempotency_key: str) -> str:
        """Return the idempotency key that is stored for one of theirs: the same key of someone else is another one.

        It follows from their name, so it stays the same after another login. Where the gateway does not ask who makes a
        request, all share their keys.
        """
        if self.name is None:
            return idempotency_key
        return hashlib.sha256(json.dumps([self.name, idempotency_key]).encode()).hexdigest()


def is_reserved(name: str) -> bool:
    """Return whether a name is that of forwarded requests, which no user and no token has."""
    return name.lower() == FORWARDER or name.lower().startswith(OF_FORWARDER)


def forwarded(name: str | None, grant: Grant, key: str) -> Principal:
    """Return who makes a request that another program forwards.

    Args:
        name: Their name there; None if it needs no login.
        grant: What they may do here.
        key: Id of the key with which the other program has signed that.
    """
    return Principal(FORWARDER if name is None else f"{OF_FORWARDER}{name}", PrincipalKind.FORWARDED, grant, key)


# Everybody, where the gateway does not ask who it is.
ANYBODY = Principal(None, PrincipalKind.ANYBODY, UNLIMITED, None)
