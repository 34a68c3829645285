"""`/session`: who one is, the dashboard's login with a token, and tickets for WebSockets."""

from contextlib import suppress
from dataclasses import asdict

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.access.tickets import LIFETIME
from dock_gateway.core.access import ANYBODY, Principal
from dock_gateway.core.errors import FieldError, InvalidField, NotAuthenticated
from dock_gateway.gateway import Gateway
from dock_gateway.web.access import cookie_name, identify, principal_of
from dock_gateway.web.openapi import body
from dock_gateway.web.problems import problems
from dock_gateway.web.requests import TheGateway, json_response, known_query, read_json, read_object
from dock_gateway.web.schemas.access import Session, Ticket

router = APIRouter(tags=["Access"], prefix="/session", dependencies=[Depends(known_query())])

# Seconds after which a browser forgets the token.
REMEMBERED = 30 * 86_400
LOGIN_REQUEST = {
    "type": "object",
    "required": ["token"],
    "additionalProperties": False,
    "properties": {"token": {"type": "string", "description": "The secret of a token, `dgw_…`"}},
}


def _session(gateway: Gateway, principal: Principal | None) -> Response:
    who = None if principal is None else {"name": principal.name, "kind": principal.kind, **asdict(principal.grant)}
    response = json_response({"required": gateway.settings.authentication, "principal": who})
    response.headers["Cache-Control"] = "no-store"
    return response


@router.get("", name="get_session", response_model=Session, responses=problems(422))
async def get_session(request: Request, gateway: TheGateway) -> Response:
    """Return who makes the request, and whether requests need a token. `principal` is null without a valid one."""
    try:
        return _session(gateway, identify(request))
    except NotAuthenticated:
        return _session(gateway, None)


@router.post(
    "",
    name="log_in",
    response_model=Session,
    responses=problems(400, 401, 408, 413, 415, 422),
    openapi_extra=body(LOGIN_REQUEST, required=True),
)
async def log_in(request: Request, gateway: TheGateway) -> Response:
    """Log a browser in with a token, which it keeps as a cookie that scripts cannot read, for 30 days at most."""
    secret = read_object(await read_json(request), "token").get("token")
    if not isinstance(secret, str):
        raise InvalidField([FieldError("token", "the secret of a token", "got something else")])
    if not gateway.settings.authentication:
        request.scope["principal"] = ANYBODY
        return _session(gateway, ANYBODY)
    request.scope["principal"] = principal = gateway.tokens.identify(secret.strip())
    response = _session(gateway, principal)
    _set_cookie(response, request, secret.strip(), REMEMBERED)
    return response


@router.delete("", name="log_out", response_model=Session, responses=problems(422))
async def log_out(request: Request, gateway: TheGateway) -> Response:
    """Let the browser forget the token. The token itself stays valid."""
    with suppress(NotAuthenticated):
        request.scope["principal"] = identify(request)
    response = _session(gateway, None if gateway.settings.authentication else ANYBODY)
    _set_cookie(response, request, "", 0)
    return response


@router.post("/ticket", name="issue_ticket", status_code=201, response_model=Ticket, responses=problems(401, 403, 422))
async def issue_ticket(request: Request, gateway: TheGateway) -> Response:
    """Return a ticket that opens one WebSocket of this gateway within 30 s, as `?ticket=`.

    For pages of other origins: a browser sends their WebSockets neither an `Authorization` header nor the cookie.
    """
    ticket = gateway.tickets.issue(principal_of(request))
    return json_response({"ticket": ticket, "expires_in_s": LIFETIME}, 201, {"Cache-Control": "no-store"})


def _set_cookie(response: Response, request: Request, secret: str, seconds: int) -> None:
    secure = request.url.scheme == "https"
    response.set_cookie(
        cookie_name(request), secret, max_age=seconds, path="/", secure=secure, httponly=True, samesite="strict"
    )
