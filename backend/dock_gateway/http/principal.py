"""Who makes a request, and whether they may: checked before every route and every command of `/ws`."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from ipaddress import ip_address
from typing import Annotated, Any

from fastapi import Depends
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response

from dock_gateway.core.access import ANYBODY, Principal
from dock_gateway.core.errors import NotAllowed
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.hub import Subscriber
from dock_gateway.core.request import PERMIT, Permit
from dock_gateway.gateway import Gateway
from dock_gateway.http.operation import Operation, operation_of
from dock_gateway.http.requests import get_gateway, read_body, read_json, read_key
from dock_gateway.http.scopes import require_covered

SCHEME = "bearer"
# The query parameter of a WebSocket that says who opens it.
TICKET = "ticket"
# Browsers accept a cookie of the first name only over TLS, from this very host.
SECURE_COOKIE, COOKIE = "__Host-dock-gateway", "dock-gateway"
# Seconds after which a browser forgets the token or the session.
REMEMBERED = 30 * 86_400
# The cookie of a browser in which a user has logged in before, and the seconds after which a browser forgets it.
BROWSER = "-browser"
BROWSER_REMEMBERED = 365 * 86_400


async def authorize(connection: HTTPConnection) -> None:
    """Identify the user of a request, and refuse what the user's grant does not allow. A dependency of every route.

    A body is read here, so that no route can act on one that was held back until the login had ended: a request is
    authorized before it, as nobody reads the bodies of strangers, and again once it is there. A stop does not wait for
    its body: it is authorized by its head alone.

    Raises:
        NotAuthenticated: The request needs a login, and has none that is valid.
        NotAllowed: Their role does not suffice (`role_required`), or it is about something beyond their limits
            (`not_covered`).
        TooManyRequests: They have sent too many goals in the last minute (`too_many_goals`).
        MalformedRequest: The body is too large, too slow or cut off.
    """
    PERMIT.set(None)  # the connection's earlier request may have left its own
    operation = operation_of(connection.scope["route"].endpoint)
    if operation.role is None:
        return
    gateway = get_gateway(connection)
    principal = await _admit(connection, operation)
    if operation.reads_body or not isinstance(connection, Request):
        return
    await read_body(connection)
    if principal.credential is not None:
        if not gateway.logins.is_valid(principal):  # it has ended, or there is another role or limit
            principal = await _admit(connection, operation)
        _permit(gateway, principal)
    if operation.sends_goal:
        gateway.quotas.spend_goal(principal)


async def _admit(connection: HTTPConnection, operation: Operation) -> Principal:
    """Return who makes a request, if they may make it now."""
    connection.scope["principal"] = principal = await identify(connection)
    name = connection.scope["route"].name
    require(principal, operation.role, name)
    names = {**connection.query_params, **connection.path_params}
    await require_covered(get_gateway(connection), principal.grant, operation.scope, names, name)
    return principal


async def identify(connection: HTTPConnection) -> Principal:
    """Return who makes a request.

    Raises:
        NotAuthenticated: The request needs a login, and has none that is valid.
        NotAllowed: It has an access token of the identity provider that gives no role (`no_role`).
        Unavailable: It has one, and the provider has not answered yet (`provider_unavailable`).
    """
    gateway = get_gateway(connection)
    ticket = connection.query_params.get(TICKET) if connection.scope["type"] == "websocket" else None
    if ticket is None and not gateway.settings.authentication:
        return ANYBODY
    if ticket is None:
        secret = secret_of(connection)
        await gateway.logins.prepare(secret)
        return gateway.logins.identify(secret)
    principal = gateway.tickets.redeem(ticket)
    gateway.logins.require_valid(principal)
    return principal


async def authorize_command(
    gateway: Gateway, principal: Principal, op: str, operation: Operation, fields: Mapping[str, Any]
) -> None:
    """Refuse a command that is not allowed. The user was identified when the connection was opened.

    Raises:
        NotAuthenticated: Their login has ended, or what they may do has changed (`invalid_token`).
        NotAllowed, TooManyRequests: As for `authorize`.
    """
    gateway.logins.require_valid(principal)
    require(principal, operation.role, op)
    await require_covered(gateway, principal.grant, operation.scope, fields, op)
    _permit(gateway, principal)
    if operation.sends_goal:
        gateway.quotas.spend_goal(principal)


def _permit(gateway: Gateway, principal: Principal) -> None:
    """Let a request or a command act for as long as its login lasts.

    Raises:
        NotAuthenticated: It has ended already: the history may have been asked what the request is about.
    """
    gateway.logins.require_valid(principal)
    PERMIT.set(Permit(partial(gateway.logins.require_valid, principal), partial(gateway.logins.watch, principal)))


def require(principal: Principal, role: Role | None, what: str) -> None:
    """Refuse a request or a command that the user's role does not allow.

    Raises:
        NotAllowed: The role does not suffice (`role_required`).
    """
    own = principal.grant.role
    if role is not None and not own.includes(role):
        raise NotAllowed(f"{what} needs the role {role}; {principal.name} is {own}", code="role_required")


def principal_of(connection: HTTPConnection) -> Principal:
    """Return who makes a request that was authorized."""
    principal: Principal = connection.scope["principal"]
    return principal


async def depend_on_grant(connection: HTTPConnection) -> Grant:
    """Return what the user of a request may do, for `Depends`."""
    return principal_of(connection).grant


TheGrant = Annotated[Grant, Depends(depend_on_grant)]


def secret_of(connection: HTTPConnection) -> str | None:
    """Return the secret that a request shows: in `Authorization: Bearer …`, or in the cookie of the dashboard."""
    scheme, _, secret = connection.headers.get("authorization", "").partition(" ")
    if scheme.lower() == SCHEME:
        return secret.strip()
    return connection.cookies.get(cookie_name(connection))


def address_of(connection: HTTPConnection) -> str:
    """Return the address of the client; behind a trusted proxy, that which the proxy names. Empty if it is none."""
    host = "" if connection.client is None else connection.client.host
    try:
        return str(ip_address(host.partition("%")[0]))
    except ValueError:
        return ""


def cookie_name(connection: HTTPConnection) -> str:
    """Return the name of the cookie with the dashboard's token or session."""
    return SECURE_COOKIE if connection.url.scheme in ("https", "wss") else COOKIE


def keep_login(response: Response, request: Request, secret: str, seconds: int = REMEMBERED) -> None:
    """Let the browser keep the secret of a token or a session as a cookie that scripts cannot read."""
    _set_cookie(response, request, cookie_name(request), secret, seconds)


def browser_of(request: Request) -> str | None:
    """Return the cookie of a browser in which a user has logged in before."""
    return request.cookies.get(cookie_name(request) + BROWSER)


def keep_browser(response: Response, request: Request, cookie: str | None) -> None:
    """Let the browser keep that a user has logged in, also after they log out."""
    if cookie is not None:
        _set_cookie(response, request, cookie_name(request) + BROWSER, cookie, BROWSER_REMEMBERED)


def _set_cookie(response: Response, request: Request, name: str, value: str, seconds: int) -> None:
    secure = request.url.scheme == "https"
    response.set_cookie(name, value, max_age=seconds, path="/", secure=secure, httponly=True, samesite="strict")


def forget_login(response: Response, request: Request) -> None:
    """Let the browser forget the secret."""
    keep_login(response, request, "", 0)


def signed(principal: Principal, fields: Any) -> Any:
    """Return a decoded body with the name of who sent it as `by`, if it is known."""
    if principal.name is None or not isinstance(fields, Mapping):
        return fields
    return {**fields, "by": principal.name}


async def read_signed_json(request: Request) -> Any:
    """Return the decoded JSON body, with the name of who sent it as `by`, if it is known.

    Raises:
        InvalidField, MalformedRequest: As `read_json`.
    """
    return signed(principal_of(request), await read_json(request))


def read_own_key(request: Request) -> str | None:
    """Return the `Idempotency-Key` header as it is stored for who makes the request.

    Raises:
        InvalidField: It is not a key.
    """
    key = read_key(request)
    return None if key is None else principal_of(request).own(key)


@contextmanager
def subscribed(gateway: Gateway, principal: Principal, event_filter: EventFilter) -> Iterator[Subscriber]:
    """Subscribe a reader while the block runs. Its stream ends when the reader's login ends or is changed.

    Raises:
        NotAuthenticated: That has happened already, since it was authorized (`invalid_token`).
        TooManyRequests: There are too many already, or too many of this user (`too_many_streams`).
        Unavailable: The gateway is shutting down.
    """
    gateway.logins.require_valid(principal)
    subscriber = gateway.hub.subscribe(event_filter)
    try:
        with gateway.quotas.hold(principal, "streams"), gateway.logins.watch(principal, subscriber.expel):
            yield subscriber
    finally:
        gateway.hub.unsubscribe(subscriber)
