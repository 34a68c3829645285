"""Carries out a command: read, allowed, recorded, done. Every door but REST sends its commands through here."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from starlette.types import Scope as ConnectionScope

from dock_gateway.access.authorization import authorize_command
from dock_gateway.audit.trail import audited_command
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import fields_of_a_message
from dock_gateway.http.operation import operation_of
from dock_gateway.http.parts import Parts

Fields = dict[str, Any]
Command = Callable[[Parts, Principal, Fields], Awaitable[Fields]]


async def carry_out(
    parts: Parts,
    principal: Principal,
    command: Command,
    request: object,
    scope: ConnectionScope,
    *,
    subject: str | None = None,
) -> Fields:
    """Carry out a command, and record it. Return its answer.

    Args:
        parts: What the command uses.
        principal: The user who sends it.
        command: The function that is declared as an operation.
        request: What the client has sent; an error if it could not be read.
        scope: The scope of the connection.
        subject: What the record says besides, such as the program that sent it.

    Raises:
        GatewayError: It could not be read, is not allowed, or failed.
    """
    operation, name = operation_of(command), command.__name__
    if operation.read is not None:
        fields = operation.read(principal, request)
    elif isinstance(request, Exception):
        raise request
    else:
        fields = request if isinstance(request, Mapping) else {}

    async def do() -> Fields:
        with fields_of_a_message():
            await authorize_command(parts, principal, name, operation, fields)
            return await command(parts, principal, dict(fields))

    return await audited_command(scope, name, operation, fields, do, subject=subject)
