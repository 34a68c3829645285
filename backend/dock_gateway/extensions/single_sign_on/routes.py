"""`/session/oidc`: the login of a browser with an identity provider. `/people`: who has logged in so."""

import logging
from collections.abc import Awaitable, Callable
from typing import Annotated, Any
from urllib.parse import urlencode

from fastapi import APIRouter, Path, Query, Request
from starlette.responses import RedirectResponse, Response

from dock_gateway.access.authorization import stranger
from dock_gateway.access.logins import Logins
from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, got
from dock_gateway.core.grant import Role
from dock_gateway.extensions.single_sign_on.login_attempt import LIFETIME, MAX_PAGE, PAGE, LoginAttempt, is_page
from dock_gateway.extensions.single_sign_on.logins import ProviderLogins
from dock_gateway.extensions.single_sign_on.schema import PersonList
from dock_gateway.http.operation import Audit, Scope, operation, public_operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import NOT_FORWARDED, address_of, cookie_name, keep_login
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.route import ApiRoute

log = logging.getLogger(__name__)
router = APIRouter(route_class=ApiRoute, tags=["Access"])

CALLBACK = "session/oidc/callback"
# Query parameter of a page that says why the login before it has failed.
LOGIN_ERROR = "login_error"
REDIRECT: dict[int | str, dict[str, Any]] = {303: {"description": "Where the browser has to go"}}


@router.get(
    "/session/oidc",
    name="begin_login",
    status_code=303,
    response_class=RedirectResponse,
    responses=REDIRECT,
    dependencies=[NOT_FORWARDED],
)
@public_operation(errors=(404, 503))
async def begin_login(
    request: Request,
    logins: Part[ProviderLogins],
    page: Annotated[
        str,
        Query(
            description="Page of the dashboard that is shown after the login",
            json_schema_extra={"pattern": f"^(?:{PAGE.pattern})$", "maxLength": MAX_PAGE},
        ),
    ] = "/",
) -> Response:
    """Send a browser to the identity provider to log in there. It has to come back within 10 minutes."""
    if not is_page(page):
        raise InvalidField([FieldError("page", "/, or a page of the dashboard such as /ui/goals", got(page), "query")])

    async def begin() -> Response:
        address, attempt = await logins.begin(page, _redirect_uri(request))
        response = RedirectResponse(address, 303)
        _keep_attempt(response, request, attempt.cookie, LIFETIME)
        return response

    return await _answer(request, page, begin)


@router.get(
    "/session/oidc/callback",
    name="finish_login",
    status_code=303,
    response_class=RedirectResponse,
    responses=REDIRECT,
    dependencies=[NOT_FORWARDED],
)
@public_operation(Audit.STORED_FIRST, any_query=True, errors=(401, 404, 409, 429, 503))
async def finish_login(request: Request, logins: Part[ProviderLogins], quotas: Part[Quotas]) -> Response:
    """Log in the browser that the identity provider sends back, with `code` and `state`. Only for providers."""
    audited(request, subject=None)  # not the query, which has the code
    attempt = LoginAttempt.read(request.cookies.get(_attempt_cookie(request)))
    page = "/" if attempt is None else attempt.page
    lifetime = 0 if logins.sso is None else int(logins.sso.lifetime.total_seconds())

    def note(person: str) -> None:
        audited(request, subject=person)

    async def finish() -> Response:
        with quotas.slot(stranger(request), "provider logins"):
            request.scope["principal"], secret = await logins.log_in(
                attempt,
                request.query_params,
                _redirect_uri(request),
                address_of(request),
                note,
            )
        response = RedirectResponse(page, 303)
        keep_login(response, request, secret, lifetime)
        return response

    response = await _answer(request, page, finish)
    _keep_attempt(response, request, "", 0)
    return response


@router.get("/people", name="list_people")
@operation(Role.ADMIN, Scope.EVERY)
async def list_people(logins: Part[ProviderLogins]) -> Answer[PersonList]:
    """List the people who are logged in with the identity provider, by name, with what they may do."""
    return json_response({"people": await logins.documents()})


@router.delete("/people/{person:path}/sessions", name="end_person_sessions", status_code=204)
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST, errors=(404,))
async def end_person_sessions(
    person: Annotated[str, Path(description="As in `/people`, such as `oidc:ada`")], logins: Part[Logins]
) -> Response:
    """Log a person out everywhere. They can log in again for as long as the identity provider lets them."""
    await logins.log_out_person(person)
    return Response(status_code=204)


async def _answer(request: Request, page: str, work: Callable[[], Awaitable[Response]]) -> Response:
    """Return an answer. A browser that shows it as a page goes to the dashboard, which says why it failed.

    Raises:
        GatewayError: It has failed, and the client is none that shows pages.
    """
    try:
        return await work()
    except GatewayError as error:
        if "text/html" not in request.headers.get("accept", ""):
            raise
        log.info("a login with the identity provider has failed: %s", error.detail)
        await audited(request).record(error.status, error.code)
        separator = "&" if "?" in page else "?"
        return RedirectResponse(f"{page}{separator}{urlencode({LOGIN_ERROR: error.code})}", 303)


def _redirect_uri(request: Request) -> str:
    """Return the address to which the provider sends the browser back. It has to know it."""
    return f"{request.url.scheme}://{request.headers['host']}/{CALLBACK}"


def _attempt_cookie(request: Request) -> str:
    return f"{cookie_name(request)}-login"


def _keep_attempt(response: Response, request: Request, value: str, seconds: int) -> None:
    """Let the browser keep what it needs to finish the login. `lax`: the provider's page leads back here."""
    secure = request.url.scheme == "https"
    response.set_cookie(
        _attempt_cookie(request), value, max_age=seconds, path="/", secure=secure, httponly=True, samesite="lax"
    )
