"""Sessions: the logins of users and of people of an identity provider. Gateways share them through the history."""

from abc import abstractmethod
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from datetime import timedelta
from typing import Any, TypeVar

from dock_gateway.access.credentials import ID_DIGITS, Credentials, new_secret
from dock_gateway.access.users import MAX_USERS
from dock_gateway.core.access import Kind, PersonSession, Principal, Session, User
from dock_gateway.core.errors import GatewayError, NotAuthenticated, NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.storage.shared_entries import SharedBook

PREFIX, PERSON_PREFIX = "dgs_", "dgo_"
# Time after which a session of a user ends at the latest.
LIFETIME = timedelta(days=30)
MAX_PER_USER = 10
# One more for each user, for logins at two gateways at the same time.
MAX_SESSIONS = (MAX_PER_USER + 1) * MAX_USERS
# Time for which the record of an ended session is kept: another gateway may know of its user's change only later.
SWEPT_AFTER = timedelta(minutes=1)

SessionT = TypeVar("SessionT", Session, PersonSession)


class BrowserSessions(Credentials[SessionT]):
    """Sessions, each with the secret in a browser's cookie.

    Args:
        book: Stores them.
    """

    refusal = "the login has ended; log in again"

    @abstractmethod
    def _valid(self, session: SessionT) -> bool:
        """Return whether a session has not ended."""

    def _over(self, session: SessionT) -> bool:
        """Return whether a session has ended for every gateway."""
        return not self._valid(session)

    async def make_room(self, name: str) -> None:
        """End the sessions of a user that were not used for longest, so that one more is not too many."""
        own = sorted((each.used_at, key) for key, each in self.book.all().items() if each.user == name)
        for _, key in own[: max(0, len(own) - MAX_PER_USER + 1)]:
            await self._remove(key)

    async def end(self, secret: str) -> None:
        """End the session of a secret, if there is one.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); the session goes on.
        """
        if (found := self.find(secret)) is not None:
            await self.book.store(found[0], None, lambda _: None)

    async def sweep(self) -> None:
        """Delete the sessions that have ended."""
        for key, session in list(self.book.all().items()):
            if utc_now() - session.created_at > SWEPT_AFTER and self._over(session):
                await self._remove(key)

    async def _remove(self, key: str) -> None:
        with suppress(GatewayError):  # another gateway has removed it, or it is removed later
            await self.book.remove(key)

    def count(self) -> Counter[str]:
        """Return the numbers of valid sessions by the names of their users."""
        return Counter(session.user for session in self.book.all().values() if self._valid(session))


class Sessions(BrowserSessions[Session]):
    """The sessions of users.

    Args:
        book: Stores them.
        users: The users, who may be changed at any time; a session has no role of its own.
    """

    def __init__(self, book: SharedBook[Session], users: SharedBook[User]) -> None:
        super().__init__(book)
        self._users = users

    def principal(self, key: str) -> Principal | None:
        """Return who shows a session, with what they may do now, if it is valid."""
        session = self.book.get(key)
        if session is None or not self._valid(session):
            return None
        user = self._users.all()[session.user]
        return Principal(session.user, Kind.USER, user.grant, key)

    def _valid(self, session: Session) -> bool:
        return session.valid(self._users.get(session.user), utc_now())

    async def create(self, name: str, era: str) -> str:
        """Create a session of a user and return its secret. The oldest one ends if there are too many.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); there is no new session.
        """
        await self.make_room(name)
        secret, digest = new_secret(PREFIX)
        now = utc_now()
        await self.book.replace(digest[:ID_DIGITS], Session(name, era, digest, now, now + LIFETIME, now))
        return secret


class PersonSessions(BrowserSessions[PersonSession]):
    """The sessions of people of an identity provider, with what the provider let them do when they logged in.

    Args:
        book: Stores them.
        issuer: The provider; None if there is none any more, and no session is valid.
    """

    def __init__(self, book: SharedBook[PersonSession], issuer: str | None) -> None:
        super().__init__(book)
        self._issuer = issuer

    def principal(self, key: str) -> Principal | None:
        """Return who shows a session, if it is valid."""
        session = self.book.get(key)
        if session is None or not self._valid(session):
            return None
        return Principal(session.user, Kind.PERSON, session.grant, key)

    def _valid(self, session: PersonSession) -> bool:
        return session.valid(self._issuer, utc_now())

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
            Conflict: There are too many sessions (`too_many_sessions`).
            Unavailable: The history does not answer (`history_unavailable`); there is no new session.
        """
        assert self._issuer is not None
        await self.make_room(name)
        secret, digest = new_secret(PERSON_PREFIX)
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
