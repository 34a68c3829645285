"""`/session`: who makes a request, the login of a browser, and tickets for WebSockets."""

from contextlib import suppress
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request

from dock_gateway.access.authorization import identify, stranger
from dock_gateway.access.logins import Logins
from dock_gateway.access.passwords import MAX_PASSWORD, describe_wrong
from dock_gateway.access.schema import Session, Ticket
from dock_gateway.access.tickets import LIFETIME, Tickets
from dock_gateway.access.user_routes import require_user
from dock_gateway.audit.trail import audited
from dock_gateway.core.access import ANYBODY, FORWARDED, Principal, PrincipalKind
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField
from dock_gateway.core.grant import Role
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Audit, Scope, operation, public_operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import (
    NOT_FORWARDED,
    ThePrincipal,
    address_of,
    browser_of,
    forget_login,
    keep_browser,
    keep_login,
    secret_of,
)
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.requests import Answer, json_response, read_json, read_object
from dock_gateway.http.route import ApiRoute
from dock_gateway.settings import Settings

router = APIRouter(route_class=ApiRoute, tags=["Access"], prefix="/session")

MAX_NAME, MAX_SECRET = 60, 1000
LOGIN_REQUEST = {
    "oneOf": [
        {
            "type": "object",
            "required": ["user", "password"],
            "additionalProperties": False,
            "properties": {
                "user": {"type": "string", "maxLength": MAX_NAME},
                "password": {"type": "string", "minLength": 1, "maxLength": MAX_PASSWORD},
            },
        },
        {
            "type": "object",
            "required": ["token"],
            "additionalProperties": False,
            "properties": {"token": {"type": "string", "description": "The secret of a token, `dgw_…`"}},
        },
    ],
    "examples": [{"user": "ada", "password": "correct horse battery staple"}],
}


def _session(request: Request, settings: Settings, logins: Logins, principal: Principal | None) -> Answer[Any]:
    who = None if principal is None else {"name": principal.name, "kind": principal.kind, **principal.grant.fields()}
    page = next((page for source in logins.sources if (page := source.page) is not None), None)
    document = {
        "required": settings.authentication,
        "open_to": None if FORWARDED in request.scope else settings.open_to,
        "principal": who,
        "hub": settings.many_sites,
        "share": [] if principal is None else settings.serve_robots,
        "provider": None if page is None else page._asdict(),
    }
    response = json_response(document)
    response.headers["Cache-Control"] = "no-store"
    return response


@router.get("", name="get_session")
@public_operation()
async def get_session(request: Request, settings: Part[Settings], logins: Part[Logins]) -> Answer[Session]:
    """Return who makes the request, and whether requests need a login. `principal` is null without a valid one.

    At a site, through its hub: whom the hub speaks for (`kind` is `hub`), and what they may do here.
    """
    try:
        return _session(request, settings, logins, await identify(request))
    except GatewayError:
        return _session(request, settings, logins, None)


@router.post("", name="log_in", openapi_extra=body(LOGIN_REQUEST, required=True), dependencies=[NOT_FORWARDED])
@public_operation(Audit.STORED_FIRST, errors=(401, 429, 503))
async def log_in(
    request: Request, settings: Part[Settings], logins: Part[Logins], quotas: Part[Quotas]
) -> Answer[Session]:
    """Log a browser in with a name and a password, or with a token.

    It keeps a cookie that scripts cannot read, for 30 days at most. After failed logins, the next one has to wait.
    """
    fields = read_object(await read_json(request), "user", "password", "token")
    if "token" in fields:
        return _log_in_with_token(request, settings, logins, fields)
    name = _read_text(fields.get("user"), MAX_NAME, "user", "a user's name").strip().lower()
    audited(request, subject=name)
    password = _read_password(fields.get("password"))
    if not settings.authentication:
        request.scope["principal"] = ANYBODY
        return _session(request, settings, logins, ANYBODY)
    browser = browser_of(request)
    with quotas.slot(stranger(request), "logins"):
        principal, secret = await logins.log_in(name, password, address_of(request), browser)
    request.scope["principal"] = principal
    response = _session(request, settings, logins, principal)
    keep_login(response, request, secret)
    keep_browser(response, request, logins.guard.known_cookie(name, browser))
    return response


def _log_in_with_token(request: Request, settings: Settings, logins: Logins, fields: dict[str, Any]) -> Answer[Any]:
    secret = _read_text(read_object(fields, "token")["token"], MAX_SECRET, "token", "the secret of a token").strip()
    if not settings.authentication:
        request.scope["principal"] = ANYBODY
        return _session(request, settings, logins, ANYBODY)
    request.scope["principal"] = principal = logins.identify_token(secret, address_of(request))
    response = _session(request, settings, logins, principal)
    keep_login(response, request, secret)
    return response


@router.delete("", name="log_out", dependencies=[NOT_FORWARDED])
@public_operation(Audit.STORED_FIRST, errors=(401, 404, 409, 503))
async def log_out(
    request: Request,
    settings: Part[Settings],
    logins: Part[Logins],
    *,
    everywhere: Annotated[bool, Query(description="Whether the sessions of all browsers of the user end")] = False,
) -> Answer[Session]:
    """End the session of the browser. A token is only forgotten: it stays valid.

    `everywhere` is for people who are logged in; without a login it is `401`, with a token `409 user_required`.
    """
    if everywhere:
        request.scope["principal"] = principal = await identify(request)
        if principal.kind is PrincipalKind.PERSON and principal.name is not None:
            await logins.log_out_person(principal.name)
        else:
            await logins.accounts.end_sessions(require_user(principal))
    else:
        with suppress(GatewayError):
            request.scope["principal"] = await identify(request)
        await logins.log_out(secret_of(request))
    response = _session(request, settings, logins, None if settings.authentication else ANYBODY)
    forget_login(response, request)
    return response


@router.post("/ticket", name="issue_ticket", status_code=201, dependencies=[NOT_FORWARDED])
@operation(Role.VIEWER, Scope.ANY)
async def issue_ticket(principal: ThePrincipal, tickets: Part[Tickets]) -> Answer[Ticket]:
    """Return a ticket that opens one WebSocket of this gateway within 30 s, as `?ticket=`.

    For pages of other origins: a browser sends their WebSockets neither an `Authorization` header nor the cookie.
    """
    ticket = tickets.issue(principal)
    return json_response({"ticket": ticket, "expires_in_s": LIFETIME}, 201, {"Cache-Control": "no-store"})


def _read_text(value: object, longest: int, path: str, expected: str) -> str:
    if not isinstance(value, str) or len(value) > longest:
        raise InvalidField([FieldError(path, f"{expected}, up to {longest} characters", "got something else")])
    return value


def _read_password(value: object) -> str:
    if (wrong := describe_wrong(value, shortest=1)) is not None:
        raise InvalidField([FieldError("password", *wrong)])
    return str(value)
