"""Administers users: adds, changes and removes them, and ends their sessions."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from dock_gateway.access.passwords import Passwords
from dock_gateway.access.sessions import Sessions
from dock_gateway.access.tokens import Tokens
from dock_gateway.access.users import Check, Users, edit, is_admin, new_era, new_user, refuse_reserved, user_document
from dock_gateway.core.access import User
from dock_gateway.core.errors import Conflict
from dock_gateway.core.grant import Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition


class Accounts:
    """The users, as admins see and change them.

    Args:
        users: All users.
        sessions: Their sessions.
        tokens: All tokens: one of them may be an admin's, and a user cannot have a token's name.
        passwords: Hashes passwords.
        end_streams: Ends the streams of those who may not do any more what they could.
    """

    def __init__(
        self, users: Users, sessions: Sessions, tokens: Tokens, passwords: Passwords, end_streams: Callable[[], None]
    ) -> None:
        self._users = users
        self._sessions = sessions
        self._tokens = tokens
        self._passwords = passwords
        self._end_streams = end_streams

    async def documents(self) -> list[dict[str, Any]]:
        """Return all users by name, as the API shows them.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        users, sessions = await self._users.read(), self._sessions.count()
        return [self._document(name, user, sessions[name]) for name, user in sorted(users.items())]

    async def document(self, name: str) -> dict[str, Any]:
        """Return a user as the API shows them.

        Raises:
            NotFound: There is no such user (`user_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        user = self._users.require(name, (await self._users.read()).get(name))
        return self._document(name, user, self._sessions.count()[name])

    def _document(self, name: str, user: User, sessions: int) -> dict[str, Any]:
        return user_document(name, user, sessions) | {"etag": self._users.book.etag(user)}

    async def add(
        self,
        name: str,
        grant: Grant,
        password: str,
        by: str | None = None,
        *,
        disabled: bool = False,
        condition: Condition = UNCONDITIONAL,
    ) -> dict[str, Any]:
        """Add a user; return them as the API shows them.

        Raises:
            ChangedMeanwhile: The condition is not true.
            Conflict: There are too many (`limit_reached`), or a user (`user_exists`) or a token (`token_exists`) has
                this name, by which records name them.
            Unavailable: The history does not answer (`history_unavailable`); there is no new user.
        """
        refuse_reserved(name)
        hashed = await self._passwords.hash(password)

        def add(user: User | None) -> User:
            condition.require(self._users.book.etag(user))
            if user is not None:
                raise Conflict(f"there is a user of the name {name}", code="user_exists")
            return new_user(grant, hashed, by, disabled=disabled)

        user = await self._users.change(name, add, dependency=self._tokens.without(name))
        assert user is not None
        return self._document(name, user, 0)

    async def edit(
        self,
        name: str,
        grant: Grant | None = None,
        password: str | None = None,
        *,
        disabled: bool | None = None,
        condition: Condition = UNCONDITIONAL,
    ) -> dict[str, Any]:
        """Change the given fields of a user; return them as the API shows them.

        Raises:
            ChangedMeanwhile: They have not the version of the condition.
            NotFound: There is no such user (`user_not_found`).
            Conflict: It is the last admin (`last_admin`).
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        hashed = None if password is None else await self._passwords.hash(password)
        user = await self._users.change(
            name,
            lambda user: edit(self._users.require(name, user, condition), grant, hashed, disabled=disabled),
            await self._keep_admin(),
        )
        self._end_streams()
        assert user is not None
        return self._document(name, user, self._sessions.count()[name])

    async def remove(self, name: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a user, and end their sessions.

        Raises:
            ChangedMeanwhile: They have not the version of the condition.
            NotFound: There is no such user (`user_not_found`).
            Conflict: It is the last admin (`last_admin`).
            Unavailable: The history does not answer (`history_unavailable`); the user is still there.
        """

        def remove(user: User | None) -> None:
            self._users.require(name, user, condition)

        await self._users.change(name, remove, await self._keep_admin())
        self._end_streams()

    async def end_sessions(self, name: str) -> None:
        """End all sessions of a user.

        Raises:
            NotFound: There is no such user (`user_not_found`).
            Unavailable: The history does not answer (`history_unavailable`); they go on.
        """
        await self._users.change(name, lambda user: replace(self._users.require(name, user), era=new_era()))
        self._end_streams()

    async def _keep_admin(self) -> Check:
        """Return a check that there is still an admin, if there is one now."""
        await self._tokens.book.read()
        needed = not self._tokens.have_admin() and any(map(is_admin, (await self._users.read()).values()))

        def check(users: Mapping[str, User]) -> None:
            if needed and not any(map(is_admin, users.values())):
                raise Conflict("this is the last admin; add another admin first", code="last_admin")

        return check
