"""Identifies users of the gateway: their sessions and tokens, and the streams that end with them."""

import asyncio
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from typing import Any

from dock_gateway.access.accounts import Accounts
from dock_gateway.access.login_delays import CHANGE, TOKENS
from dock_gateway.access.login_guard import LoginGuard
from dock_gateway.access.login_source import LoginSource
from dock_gateway.access.passwords import Passwords
from dock_gateway.access.sessions import MAX_SESSIONS, PREFIX, Sessions
from dock_gateway.access.tokens import MAX_TOKENS, Tokens
from dock_gateway.access.users import MAX_USERS, Users, edit, refuse_reserved
from dock_gateway.core.access import (
    Principal,
    PrincipalKind,
    Session,
    Token,
    User,
)
from dock_gateway.core.errors import (
    Conflict,
    NotAllowed,
    NotAuthenticated,
)
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.core.listeners import Hooks
from dock_gateway.core.tasks import Tasks
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SYNC_INTERVAL, SharedBook

log = logging.getLogger(__name__)


def login_ended() -> NotAuthenticated:
    """Return the error for who was logged in when they began."""
    return NotAuthenticated("the login has ended or was changed; connect again", code="invalid_token")


class Logins:
    """Users, sessions and tokens.

    What changes at other gateways is known after `SYNC_INTERVAL` seconds. While the history does not answer, what was
    valid before goes on.

    Args:
        history: Stores them.
        where: The database, for the log.
        sync_interval: Seconds between two reads of what other gateways have changed.

    Attributes:
        accounts: Administers the users.
        sources: What else says who makes a request.
    """

    def __init__(
        self,
        history: History,
        where: str = "",
        *,
        sync_interval: float = SYNC_INTERVAL,
    ) -> None:
        self._sync_interval = sync_interval
        self.tokens = Tokens(SharedBook(history.documents("token", Token), "token", MAX_TOKENS, {"used_at"}), where)
        self._where = where
        # The login of a user is no change of what an admin has written.
        users = SharedBook(history.documents("user", User), "user", MAX_USERS, {"logged_in_at", "era"})
        self._users = Users(users)
        sessions = SharedBook(history.documents("session", Session), "session", MAX_SESSIONS)
        self._sessions = Sessions(sessions, self._users.book)
        self.sources = Hooks[LoginSource]()
        self._passwords = Passwords()
        self.accounts = Accounts(self._users, self._sessions, self.tokens, self._passwords, self.end_streams)
        self.guard = LoginGuard(self._users.book.get)
        self._streams: dict[Principal, set[Callable[[], object]]] = {}
        self._tasks = Tasks("watching logins")

    async def open(self) -> None:
        """Read who may log in, and watch that from now on."""
        await self.refresh()
        self._tasks.spawn(self._run())

    async def _warn_if_empty(self) -> None:
        """Log how to add the first user, if no one can log in."""
        if (
            not any(each.page for each in self.sources)
            and await self._users.book.sync()
            and not (self._users.book.keys() | self.tokens.book.keys())
        ):
            log.warning(
                "no one can log in yet: there are no users or tokens in the database. This adds the first user: "
                "`dock-gateway user create NAME --role admin --database-url %s`",
                self._where or "URL",
            )

    async def _run(self) -> None:
        await asyncio.sleep(self._sync_interval)  # the sources are open by then
        await self._warn_if_empty()
        while True:
            await self.refresh()
            await asyncio.sleep(self._sync_interval)

    async def refresh(self) -> None:
        """End the streams whose login has ended or changed, record uses, and read changes of other gateways."""
        self.end_streams()
        await self.tokens.refresh()
        await self._sessions.refresh()  # before the users: a new session's user is known
        await self._users.book.sync()
        await self._sessions.sweep()
        for source in self.sources:
            await source.refresh()
        self.end_streams()

    async def close(self) -> None:
        """Watch no longer."""
        await self._tasks.close()

    # ------------------------------------------------------------------ who makes a request

    def identify(self, secret: str | None) -> Principal:
        """Return who shows this secret.

        Raises:
            NotAuthenticated: There is no secret, or no valid token or session with it (`invalid_token`).
            NotAllowed: A source knows them, and they have no role (`role_required`).
        """
        if secret is None:
            raise NotAuthenticated("this gateway asks for a login: log in, or send `Authorization: Bearer dgw_…`")
        if secret.startswith(PREFIX):
            return self._sessions.identify(secret)
        source = self._source_of(secret)
        return self.tokens.identify(secret) if source is None else source.identify(secret)

    def _source_of(self, secret: str) -> LoginSource | None:
        return next((each for each in self.sources if each.reads(secret)), None)

    async def prepare(self, secret: str | None) -> None:
        """Let a source ask for what `identify` needs to know for this secret.

        Raises:
            Unavailable: It has no answer, and has had none since the gateway was started.
        """
        if secret is not None and (source := self._source_of(secret)) is not None:
            await source.prepare(secret)

    def is_valid(self, principal: Principal) -> bool:
        """Return whether someone is still logged in, and may do what they could when they were identified."""
        principal = principal.login or principal
        # What another program forwards: it ends the streams of those whose login has ended there.
        if principal.credential is None or principal.kind is PrincipalKind.FORWARDED:
            return True
        match principal.kind:
            case PrincipalKind.PERSON | PrincipalKind.SERVICE:
                return any(each.is_valid(principal) for each in self.sources)
            case PrincipalKind.USER:
                current = self._sessions.principal(principal.credential)
            case _:
                current = self.tokens.principal(principal.credential)
        return current == principal

    def require_valid(self, principal: Principal) -> None:
        """Refuse someone who was identified earlier, if that is no longer true.

        Raises:
            NotAuthenticated: Their login has ended, or what they may do has changed (`invalid_token`).
        """
        if not self.is_valid(principal):
            raise login_ended()

    @contextmanager
    def watch(self, principal: Principal, end: Callable[[], object]) -> Iterator[None]:
        """Call `end` as soon as it is known that `is_valid` is no longer true, while the block runs."""
        ends = self._streams.setdefault(principal, set())
        ends.add(end)
        try:
            yield
        finally:
            ends.discard(end)
            if not ends:
                self._streams.pop(principal, None)

    def end_streams(self) -> None:
        """End the streams of those who are no longer logged in, or may not do any more what they could."""
        for principal, ends in list(self._streams.items()):
            if not self.is_valid(principal):
                for end in list(ends):
                    end()

    # ------------------------------------------------------------------ tokens

    async def create_token(
        self, name: str, grant: Grant, expires_at: datetime | None = None, by: str | None = None
    ) -> tuple[dict[str, Any], str]:
        """Create a token; return it as the API shows it, and its secret, which is not stored.

        Raises:
            Conflict: There are too many (`limit_reached`), or a token (`token_exists`) or a user (`user_exists`) has
                this name, by which records name them.
            Unavailable: The history does not answer (`history_unavailable`); there is no new token.
        """
        for prefix in (source.prefix for source in self.sources):
            if name.lower().startswith(prefix):
                detail = f"names that begin with {prefix} are of people and services who log in elsewhere"
                raise Conflict(detail, code="user_exists")
        refuse_reserved(name)
        return await self.tokens.create(name, grant, expires_at, by, self._users.without(name))

    async def revoke_token(self, token_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Make a token invalid, and end its streams.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: There is no such token (`token_not_found`).
            Unavailable: The history does not answer (`history_unavailable`); the token is still valid.
        """
        await self.tokens.book.remove(token_id, condition)
        self.end_streams()

    def identify_token(self, secret: str, address: str) -> Principal:
        """Return who shows the secret of a token, for a login. A valid token is never delayed: none can be guessed.

        Raises:
            NotAuthenticated: There is no valid token with it (`invalid_token`).
            TooManyRequests: There were too many failed logins (`too_many_logins`).
        """
        try:
            return self.tokens.identify(secret)
        except NotAuthenticated:
            with self.guard.counted(TOKENS, address):
                raise

    # ------------------------------------------------------------------ sessions

    async def log_in(self, name: str, password: str, address: str, browser: str | None = None) -> tuple[Principal, str]:
        """Log a user in; return who that is, and the secret of the new session, which is not stored.

        Args:
            name: The user's name.
            password: The password.
            address: The client's address.
            browser: The cookie of `LoginGuard.known_cookie`, if the client has one.

        Raises:
            NotAuthenticated: The name or the password is wrong, or the user is disabled (`invalid_login`).
            TooManyRequests: There were too many failed logins (`too_many_logins`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        wrong = NotAuthenticated("the name or the password is wrong, or the user is disabled", code="invalid_login")
        with self.guard.counted(name, address, browser):
            known = (await self._users.read()).get(name)
            right, outdated = await self._passwords.verify(password, None if known is None else known.password)
            if known is None or not right:
                raise wrong

            def record(user: User | None) -> User:
                if user is None or user.disabled or user.era != known.era:
                    raise wrong
                return replace(user, password=outdated or user.password, logged_in_at=utc_now())

            user = await self._users.change(name, record)
            assert user is not None
            secret = await self._sessions.create(name, user.era)
        return self._sessions.identify(secret), secret

    async def log_out(self, secret: str | None) -> None:
        """End the session of a secret, if it is one.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); the session goes on.
        """
        if secret is not None:
            source = self._source_of(secret)
            await (self._sessions.end(secret) if source is None else source.log_out(secret))
            self.end_streams()

    async def log_out_person(self, name: str) -> None:
        """End all sessions of a person who has logged in elsewhere.

        Raises:
            NotFound: They have none any more.
            Unavailable: The history does not answer (`history_unavailable`); some go on.
        """
        try:
            for source in self.sources:
                if name.startswith(source.prefix):
                    await source.log_out_everywhere(name)
        finally:
            self.end_streams()

    async def change_password(self, name: str, old: str, new: str, address: str) -> str:
        """Change the password of a user who knows the old one; return the secret of a new session. All others end.

        Raises:
            NotAllowed: The old password is wrong (`wrong_password`).
            TooManyRequests: There were too many failed logins (`too_many_logins`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        wrong = NotAllowed("the old password is wrong", code="wrong_password")
        with self.guard.counted(CHANGE + name, address):
            known = self._users.require(name, (await self._users.read()).get(name))
            right, _ = await self._passwords.verify(old, known.password)
            if not right:
                raise wrong
        hashed = await self._passwords.hash(new)

        def change(user: User | None) -> User:
            if user is None or user.era != known.era:
                raise wrong
            return edit(user, None, hashed, disabled=None)

        user = await self._users.change(name, change)
        assert user is not None
        # The streams end with the next `refresh`: by then the browser has the new session.
        return await self._sessions.create(name, user.era)
