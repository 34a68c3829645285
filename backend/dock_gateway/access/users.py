"""Users, who log in with a name and a password. Gateways share them through the history."""

import asyncio
import re
import secrets
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from dock_gateway.core.access import FORWARDER, OF_FORWARDER, User, is_reserved
from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.request import act
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.storage import Dependency
from dock_gateway.storage.shared_entries import SharedBook

MAX_USERS = 200
USER_NAME = re.compile(r"[a-z0-9](?:[a-z0-9._@+-]{0,58}[a-z0-9])?")
# How often a change is tried that other gateways are faster than.
TRIES = 20

Change = Callable[[User | None], User | None]
Check = Callable[[Mapping[str, User]], None]


class Users:
    """The users by name.

    Args:
        book: Stores them.
    """

    def __init__(self, book: SharedBook[User]) -> None:
        self.book = book
        self._changing = asyncio.Lock()

    async def change(
        self, name: str, change: Change, check: Check = lambda _: None, dependency: Dependency | None = None
    ) -> User | None:
        """Change a user as they are stored now, and return what they are then.

        Args:
            name: The user's name.
            change: Is given the user, None if there is none, and returns the new one; None removes them. May be called
                again if another gateway changes the user at the same time.
            check: Is given all users after the change, and raises if it must not be stored.
            dependency: Entries of another kind that are checked in the same transaction.

        Raises:
            NotAuthenticated: The login of who changes them has ended meanwhile (`invalid_token`).
            Conflict: There are too many (`limit_reached`), or others change the user all the time (`user_changed`).
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        async with self._changing:
            for _ in range(TRIES):
                old = (await self.book.read()).get(name)
                new = change(old)
                act()
                try:
                    await self._store(name, old, new, check, dependency)
                except _OvertakenError:
                    continue
                return new
        raise Conflict(f"{name} is being changed by others; try again", code="user_changed")

    async def _store(
        self, name: str, old: User | None, new: User | None, check: Check, dependency: Dependency | None
    ) -> None:
        def check_all(users: Mapping[str, User]) -> None:
            if users.get(name) != old:
                raise _OvertakenError
            others = {key: user for key, user in users.items() if key != name}
            check(others if new is None else {**others, name: new})

        if new is None:
            await self.book.store(name, None, check_all, dependency)
        else:
            await self.book.replace(name, new, check_all, dependency)

    def without(self, name: str) -> Dependency:
        """Return a check that no user has a name, whatever its case."""

        def check(users: Mapping[str, User]) -> None:
            if name.lower() in users:
                raise Conflict(f"there is a user of the name {name}", code="user_exists")

        return self.book.dependency(check)

    async def read(self) -> Mapping[str, User]:
        """Return all users by name, as they are stored now.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self.book.read()

    def require(self, name: str, user: User | None, condition: Condition = UNCONDITIONAL) -> User:
        """Return the user of this name, as they were read.

        Raises:
            ChangedMeanwhile: They have not the version of the condition.
            NotFound: There was none (`user_not_found`).
        """
        if user is None:
            raise self.book.missing(name)
        condition.require(self.book.etag(user))
        return user


class _OvertakenError(Exception):
    """Another gateway or request has changed the user in the meantime."""


def refuse_reserved(name: str) -> None:
    """Refuse a name that records use for others.

    Raises:
        Conflict: It is one (`user_exists`).
    """
    if is_reserved(name):
        detail = f"the name {FORWARDER}, and names that begin with {OF_FORWARDER}, are reserved"
        raise Conflict(detail, code="user_exists")


def new_era() -> str:
    """Return an era, with which all earlier sessions end."""
    return secrets.token_hex(8)


def new_user(grant: Grant, password: str, by: str | None, *, disabled: bool) -> User:
    """Return a new user with this hash of a password."""
    return User(
        **grant.fields(),
        password=password,
        era=new_era(),
        disabled=disabled,
        created_by=by,
        created_at=utc_now(),
        logged_in_at=None,
    )


def edit(user: User, grant: Grant | None, password: str | None, *, disabled: bool | None) -> User:
    """Return a user with the given changes. A new password, or being disabled, ends the sessions."""
    ends = password is not None or (disabled is True and not user.disabled)
    return replace(
        user,
        **({} if grant is None else grant.fields()),
        password=password or user.password,
        disabled=user.disabled if disabled is None else disabled,
        era=new_era() if ends else user.era,
    )


def is_admin(user: User) -> bool:
    """Return whether a user is an admin who can log in."""
    return user.role is Role.ADMIN and not user.disabled


def user_document(name: str, user: User, sessions: int) -> dict[str, Any]:
    """Return a user as the API shows them."""
    document = {"name": name, **vars(user), "sessions": sessions}
    del document["password"], document["era"]
    return document
