"""The sessions of people of an identity provider. Gateways share them through the history."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.access.credentials import ID_DIGITS, new_secret
from dock_gateway.access.sessions import BrowserSessions
from dock_gateway.core.access import IDLE, Principal, PrincipalKind
from dock_gateway.core.errors import NotAuthenticated, NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.storage.shared_entries import SharedBook

PREFIX = "dgo_"


@dataclass(frozen=True)
class PersonSession:
    """The login of a person of the identity provider in one browser, as stored: without its secret.

    Attributes:
        user: How records name the person, `oidc:…`.
        issuer: The provider.
        subject: The provider's id of the person.
        role: What they may do.
        robots, actions, topics: With what, as in `Grant`.
        digest: SHA-256 of the secret, in hexadecimal digits.
        attempt: SHA-256 of the state of the login, which leads to one session only.
        created_at: When the person logged in.
        expires_at: When it ends at the latest.
        used_at: When it was used last, to the minute.
    """

    user: str
    issuer: str
    subject: str
    role: Role
    robots: tuple[str, ...]
    actions: tuple[str, ...]
    topics: tuple[str, ...]
    digest: str
    attempt: str
    created_at: datetime
    expires_at: datetime
    used_at: datetime

    @property
    def grant(self) -> Grant:
        """The grant of the person."""
        return Grant(self.role, self.robots, self.actions, self.topics)

    def valid(self, issuer: str | None, now: datetime) -> bool:
        """Return whether it has not ended.

        Args:
            issuer: The provider where people log in now.
            now: The time.
        """
        return issuer == self.issuer and now < self.expires_at and now < self.used_at + IDLE


class PersonSessions(BrowserSessions[PersonSession]):
    """The sessions of people of an identity provider, with what the provider let them do when they logged in.

    Args:
        book: Stores them.
        issuer: The provider; None if there is none any more, and no session is valid.
    """

    def __init__(self, book: SharedBook[PersonSession], issuer: str | None) -> None:
        super().__init__(book)
        self._issuer = issuer

    def _valid(self, entry: PersonSession) -> bool:
        return entry.valid(self._issuer, utc_now())

    def _principal(self, key: str, entry: PersonSession) -> Principal:
        return Principal(entry.user, PrincipalKind.PERSON, entry.grant, key)

    def _over(self, session: PersonSession) -> bool:
        return not session.valid(session.issuer, utc_now())  # another gateway may have another provider

    async def create(self, name: str, subject: str, grant: Grant, attempt: str, lifetime: timedelta) -> str:
        """Create a session of a person and return its secret. The oldest one ends if there are too many.

        Args:
            name: How records name the person.
            subject: The provider's id of them.
            grant: What they may do.
            attempt: Digest of the state of the login.
            lifetime: How long the session lasts at most.

        Raises:
            NotAuthenticated: This login has led to a session already, here or at another gateway (`login_failed`).
            Conflict: There are too many sessions (`limit_reached`).
            Unavailable: The history does not answer (`history_unavailable`); there is no new session.
        """
        assert self._issuer is not None
        await self.make_room(name)
        secret, digest = new_secret(PREFIX)
        now = utc_now()
        session = PersonSession(
            name,
            self._issuer,
            subject,
            **grant.fields(),
            digest=digest,
            attempt=attempt,
            created_at=now,
            expires_at=now + lifetime,
            used_at=now,
        )

        def check(sessions: Mapping[str, PersonSession]) -> None:
            if any(each.attempt == attempt for each in sessions.values()):
                raise NotAuthenticated("the login has failed: it was used already", code="login_failed")

        await self.book.replace(digest[:ID_DIGITS], session, check)
        return secret

    async def end_all(self, name: str) -> None:
        """End all sessions of a person.

        Raises:
            NotFound: The person has none (`person_not_found`).
            Unavailable: The history does not answer (`history_unavailable`); some go on.
        """
        own = [key for key, session in (await self.book.read()).items() if session.user == name]
        if not own:
            raise NotFound(f"{name} is not logged in", code="person_not_found")
        for key in own:
            await self.book.store(key, None, lambda _: None)

    async def documents(self) -> list[dict[str, Any]]:
        """Return the people who are logged in by name, as the API shows them.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        sessions = sorted((await self.book.read()).values(), key=lambda session: session.created_at)
        people = {(session.user, session.subject): session for session in sessions if self._valid(session)}
        numbers = Counter((session.user, session.subject) for session in sessions if self._valid(session))
        return [_person_document(people[person], numbers[person]) for person in sorted(people)]


def _person_document(newest: PersonSession, sessions: int) -> dict[str, Any]:
    return {
        "name": newest.user,
        "subject": newest.subject,
        **newest.grant.fields(),
        "sessions": sessions,
        "logged_in_at": newest.created_at,
        "expires_at": newest.expires_at,
    }
