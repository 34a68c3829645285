"""Checks whether a request or a command of `/ws` is allowed: before each, and while a stream lasts."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

from starlette.requests import HTTPConnection, Request

from dock_gateway.access.login_delays import network_of
from dock_gateway.access.logins import Logins
from dock_gateway.access.scopes import require_covered
from dock_gateway.access.tickets import Tickets
from dock_gateway.core.access import ANYBODY, FORWARDED, Principal
from dock_gateway.core.errors import GatewayError, NotAllowed
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.request import PERMIT, Permit
from dock_gateway.core.share import Share
from dock_gateway.http.operation import Operation, operation_of
from dock_gateway.http.parts import Parts, parts_of
from dock_gateway.http.principal import TICKET, address_of, secret_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.requests import read_body
from dock_gateway.settings import Settings


async def authorize(connection: HTTPConnection) -> None:
    """Identify the user of a request, and refuse what the user's grant does not allow. A dependency of every route.

    A body is read here, so that no route can act on one that was held back until the login had ended: a request is
    authorized before it, as no body of a stranger is read, and again once it is there. A stop does not wait for
    its body: it is authorized by its head alone. Nor does canceling a goal, which takes none.

    Raises:
        NotAuthenticated: The request needs a login, and has none that is valid.
        NotAllowed: Their role does not suffice (`role_required`), or it is about something beyond their limits
            (`not_allowed`).
        ServedElsewhere: It is about a robot that another gateway serves.
        TooManyRequests: They have sent too many goals in the last minute (`too_many_goals`).
        MalformedRequest: The body is too large, too slow or cut off.
    """
    PERMIT.set(None)  # the connection's earlier request may have left its own
    operation = operation_of(connection.scope["route"].endpoint)
    if operation.role is None:
        return
    parts = parts_of(connection)
    principal = await _admit(connection, operation)
    if operation.reads_body or not isinstance(connection, Request):
        return
    if not operation.stops:
        await read_body(connection)
    if not parts[Logins].is_valid(principal):  # it has ended, or there is another role or limit
        principal = await _admit(connection, operation)
    _permit(parts, principal)
    if operation.sends_goal:
        parts[Quotas].spend_goal(principal)


async def _admit(connection: HTTPConnection, operation: Operation) -> Principal:
    """Return who makes a request, if they may make it now."""
    connection.scope["principal"] = principal = await identify(connection)
    name = connection.scope["route"].name
    require(principal, operation.role, name)
    names = {**connection.query_params, **connection.path_params}
    await require_covered(parts_of(connection), principal.grant, operation.scope, names, name)
    return principal


async def identify(connection: HTTPConnection) -> Principal:
    """Return who makes a request. Of one that another program forwards, that one has signed it.

    The grant does not go beyond this gateway's share of the robots.

    Raises:
        NotAuthenticated: The request needs a login, and has none that is valid.
        NotAllowed: It has an access token of the identity provider that gives no role (`role_required`).
        Unavailable: It has one, and the provider has not answered yet (`provider_unavailable`).
    """
    principal = await _identify(connection)
    if not parts_of(connection)[Settings].serve_robots:
        return principal
    return replace(principal, grant=parts_of(connection)[Share].narrow(principal.grant))


async def sees_all(connection: HTTPConnection) -> bool:
    """Return whether a request that needs no login is one of a user without limits."""
    try:
        return not (await identify(connection)).grant.limited
    except GatewayError:
        return False


async def _identify(connection: HTTPConnection) -> Principal:
    principal: Principal | None = connection.scope.get(FORWARDED)
    if principal is not None:
        return principal
    parts = parts_of(connection)
    ticket = connection.query_params.get(TICKET) if connection.scope["type"] == "websocket" else None
    if ticket is None and not parts[Settings].authentication:
        return anybody(connection)
    logins = parts[Logins]
    if ticket is None:
        secret = secret_of(connection)
        await logins.prepare(secret)
        return logins.identify(secret)
    principal = parts[Tickets].redeem(ticket)
    logins.require_valid(principal)
    return principal


def anybody(connection: HTTPConnection) -> Principal:
    """Return who makes a request without a login: a client at an address."""
    return replace(ANYBODY, address=network_of(address_of(connection)))


def stranger(connection: HTTPConnection) -> Principal:
    """Return who is about to log in: a client at an address, who may do nothing yet."""
    return replace(anybody(connection), grant=Grant(Role.VIEWER))


async def authorize_command(
    parts: Parts, principal: Principal, op: str, operation: Operation, fields: Mapping[str, Any]
) -> None:
    """Refuse a command that is not allowed. The user was identified when the connection was opened.

    Raises:
        NotAuthenticated: Their login has ended, or what they may do has changed (`invalid_token`).
        NotAllowed, TooManyRequests: As for `authorize`.
    """
    parts[Logins].require_valid(principal)
    require(principal, operation.role, op)
    await require_covered(parts, principal.grant, operation.scope, fields, op)
    _permit(parts, principal)
    if operation.sends_goal:
        parts[Quotas].spend_goal(principal)


def _permit(parts: Parts, principal: Principal) -> None:
    """Let a request or a command act for as long as its login lasts.

    Raises:
        NotAuthenticated: It has ended already: the history may have been asked what the request is about.
    """
    logins, quotas = parts[Logins], parts[Quotas]
    logins.require_valid(principal)
    PERMIT.set(
        Permit(
            partial(logins.require_valid, principal),
            partial(logins.watch, principal),
            partial(quotas.slot, principal),
            partial(quotas.turn, principal),
        )
    )


def require(principal: Principal, role: Role | None, what: str) -> None:
    """Refuse a request or a command that the user's role does not allow.

    Raises:
        NotAllowed: The role does not suffice (`role_required`).
    """
    own = principal.grant.role
    if role is not None and not own.includes(role):
        detail = f"{what} needs the role {role}; {principal.name} is {own}"
        raise NotAllowed(detail, code="role_required", role=role)


@contextmanager
def subscribed(parts: Parts, principal: Principal, event_filter: EventFilter) -> Iterator[Subscriber]:
    """Subscribe a reader while the block runs. Its stream ends when the reader's login ends or is changed.

    Raises:
        NotAuthenticated: That has happened already, since it was authorized (`invalid_token`).
        TooManyRequests: The user has too many, or all users together (`too_many_streams`).
        Unavailable: The gateway is shutting down.
    """
    logins, fanout = parts[Logins], parts[Fanout]
    logins.require_valid(principal)
    with parts[Quotas].slot(principal, "streams"):
        subscriber = fanout.subscribe(event_filter)
        try:
            with logins.watch(principal, subscriber.expel):
                yield subscriber
        finally:
            fanout.unsubscribe(subscriber)
