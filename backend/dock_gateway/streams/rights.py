"""Authorizes and audits each operation of a connection as `/ws` does."""

from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager
from typing import Any, TypeVar

from starlette.types import Scope as ConnectionScope

from dock_gateway.access.authorization import authorize_command
from dock_gateway.access.carry_out import carry_out
from dock_gateway.audit.trail import audited_command
from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Grant
from dock_gateway.http.operation import operation_of
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.streams.commands import COMMANDS

Json = dict[str, Any]
T = TypeVar("T")


class Rights:
    """The rights of a connection's user.

    Args:
        scope: The scope of the WebSocket.
        parts: Carry out the operations.
        principal: The user.

    Attributes:
        principal: The user.
    """

    def __init__(self, scope: ConnectionScope, parts: Parts, principal: Principal) -> None:
        self.principal = principal
        self._scope = scope
        self._parts = parts

    @property
    def grant(self) -> Grant:
        """The grant of the user."""
        return self.principal.grant

    def turn(self, what: str) -> AbstractAsyncContextManager[None]:
        """Wait for the user's turn (`Quotas.turn`)."""
        return self._parts[Quotas].turn(self.principal, what)

    async def require(self, function: Callable[..., object], fields: Json) -> None:
        """Refuse an operation that is not allowed.

        Args:
            function: Declares what the operation needs.
            fields: What it is about.

        Raises:
            NotAuthenticated, NotAllowed, TooManyRequests: As `authorize_command`.
        """
        await authorize_command(self._parts, self.principal, function.__name__, operation_of(function), fields)

    async def perform(
        self,
        function: Callable[..., object],
        fields: Json,
        do: Callable[[], Awaitable[T]],
        *,
        recorded: bool = True,
        subject: str | None = None,
    ) -> T:
        """Perform what is an operation, but no command, if it is allowed, and record it. Return its answer.

        Args:
            function: Declares what the operation needs. It is none that reads a request itself, such as a stop: that is
                a `command`.
            fields: What it is about.
            do: Carries it out.
            recorded: Whether the audit log has it. It only reads, or was recorded when it was prepared, if not.
            subject: What the audit log says that it is about, if that is more than the name in the fields.

        Raises:
            GatewayError: It is not allowed (as `require`), or failed.
        """

        async def authorized() -> T:
            await self.require(function, fields)
            return await do()

        if not recorded:
            return await authorized()
        return await self._recorded(function, fields, authorized, subject)

    async def _recorded(
        self, function: Callable[..., object], fields: Json, do: Callable[[], Awaitable[T]], subject: str | None = None
    ) -> T:
        name, operation = function.__name__, operation_of(function)
        return await audited_command(self._scope, name, operation, fields, do, subject=subject)

    async def command(self, name: str, request: object) -> Json:
        """Carry out a command. `request` is what the client has sent, an error if it could not be read."""
        return await carry_out(self._parts, self.principal, COMMANDS[name], request, self._scope)

    async def cancel(self, goal_id: str) -> None:
        """Cancel a goal of this user, even if the login has ended: its client is gone, and wanted it."""
        fields = {"goal_id": goal_id}
        cancel = COMMANDS["cancel_goal"]
        await self._recorded(cancel, fields, lambda: cancel(self._parts, self.principal, fields))
