"""The user of a request: the secret that identifies them, the cookies of a browser, and the name in `by`."""

from collections.abc import Mapping
from ipaddress import ip_address
from typing import Annotated, Any

from fastapi import Depends
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response

from dock_gateway.core.access import FORWARDED, Principal
from dock_gateway.core.errors import NotAllowed
from dock_gateway.core.grant import Grant, Role
from dock_gateway.http.requests import read_json, read_key

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


def principal_of(connection: HTTPConnection) -> Principal:
    """Return who makes a request that was authorized."""
    principal: Principal = connection.scope["principal"]
    return principal


async def refuse_forwarded(connection: HTTPConnection) -> None:
    """Refuse a request that another program forwards, for `Depends`: it is about logins of this gateway.

    Raises:
        NotAllowed: It is one (`not_through_hub`).
    """
    if FORWARDED in connection.scope:
        raise NotAllowed(
            "these logins are not for requests that another program forwards: log in there", code="not_through_hub"
        )


async def refuse_forwarded_below_admin(connection: HTTPConnection) -> None:
    """Refuse a request that another program forwards, for `Depends`, unless an admin makes it.

    Raises:
        NotAllowed: They are no admin here (`not_through_hub`).
    """
    if FORWARDED in connection.scope and principal_of(connection).grant.role is not Role.ADMIN:
        raise NotAllowed("a forwarded request for this needs the role admin at the site", code="not_through_hub")


# What goes into `dependencies` of a route or a router.
NOT_FORWARDED, ADMIN_IF_FORWARDED = Depends(refuse_forwarded), Depends(refuse_forwarded_below_admin)


async def depend_on_grant(connection: HTTPConnection) -> Grant:
    """Return what the user of a request may do, for `Depends`."""
    return principal_of(connection).grant


async def depend_on_principal(connection: HTTPConnection) -> Principal:
    """Return who makes a request, for `Depends`."""
    return principal_of(connection)


ThePrincipal = Annotated[Principal, Depends(depend_on_principal)]
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
