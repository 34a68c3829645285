"""Sessions: logins in a browser. Gateways share them through the history."""

from collections import Counter
from contextlib import suppress
from datetime import datetime, timedelta
from typing import Protocol, TypeVar

from dock_gateway.access.credentials import ID_DIGITS, Credential, Credentials, new_secret
from dock_gateway.access.users import MAX_USERS
from dock_gateway.core.access import Principal, PrincipalKind, Session, User
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.storage.shared_entries import SharedBook

PREFIX = "dgs_"
# Time after which a session of a user ends at the latest.
LIFETIME = timedelta(days=30)
MAX_PER_USER = 10
# One more for each user, for logins at two gateways at the same time.
MAX_SESSIONS = (MAX_PER_USER + 1) * MAX_USERS
# Time for which the record of an ended session is kept: another gateway may know of its user's change only later.
SWEPT_AFTER = timedelta(minutes=1)


class StoredSession(Credential, Protocol):
    """A session as it is stored."""

    @property
    def user(self) -> str:
        """Whose it is."""

    @property
    def created_at(self) -> datetime:
        """When they logged in."""

    @property
    def used_at(self) -> datetime:
        """When it was used last, to the minute."""


SessionT = TypeVar("SessionT", bound=StoredSession)


class BrowserSessions(Credentials[SessionT]):
    """Sessions, each with the secret in a browser's cookie.

    Args:
        book: Stores them.
    """

    refusal = "the login has ended; log in again"

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

    def _valid(self, entry: Session) -> bool:
        return entry.valid(self._users.get(entry.user), utc_now())

    def _principal(self, key: str, entry: Session) -> Principal:
        user = self._users.all()[entry.user]
        return Principal(entry.user, PrincipalKind.USER, user.grant, key)

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
