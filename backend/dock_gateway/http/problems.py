"""Turns the errors of the core, FastAPI and Starlette into problem+json, for requests and for WebSockets."""

from http import HTTPStatus
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.datastructures import URL
from starlette.exceptions import HTTPException
from starlette.middleware.exceptions import ExceptionMiddleware
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.websockets import WebSocket

from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, got
from dock_gateway.core.goal import encode
from dock_gateway.http.bodies import expectation
from dock_gateway.http.methods import AllowedMethods
from dock_gateway.http.requests import Answer

MEDIA_TYPE = "application/problem+json"
INTERNAL = GatewayError("internal error; the gateway's log has the details")
# What may succeed later: the answer says when.
RETRIED = {HTTPStatus.SERVICE_UNAVAILABLE, HTTPStatus.TOO_MANY_REQUESTS}
CODES = {307: "redirected", 404: "not_found", 405: "method_not_allowed"}


def problem_response(error: GatewayError) -> Response:
    """Return the answer for an error."""
    headers = {}
    if error.status in RETRIED:
        headers["Retry-After"] = str(error.extra.get("retry_after", 1))
    if error.status is HTTPStatus.UNAUTHORIZED:
        headers["WWW-Authenticate"] = "Bearer"
    if error.status in (HTTPStatus.REQUEST_ENTITY_TOO_LARGE, HTTPStatus.REQUEST_TIMEOUT):
        headers["Connection"] = "close"  # the rest of the body is not read
    if error.status is HTTPStatus.UPGRADE_REQUIRED:
        headers |= {"Upgrade": "websocket", "Connection": "Upgrade"}
    return Answer(encode(error.problem()), error.status, headers, MEDIA_TYPE)


def problems(*statuses: int, schema: str = "Problem") -> dict[int | str, dict[str, Any]]:
    """Return the `responses=` of a route that can fail with these statuses."""
    content = {MEDIA_TYPE: {"schema": {"$ref": f"#/components/schemas/{schema}"}}}
    found: dict[int | str, dict[str, Any]] = {
        status: {"description": HTTPStatus(status).phrase, "content": content} for status in statuses
    }
    for status in RETRIED & set(statuses):
        found[status]["headers"] = {
            "Retry-After": {"description": "Seconds after which it may succeed", "schema": {"type": "integer"}}
        }
    return found


def install_problems(app: FastAPI, allowed: AllowedMethods = lambda _: None, *, many_sites: bool = False) -> None:
    """Register the handlers, for routes and for middleware that was added before.

    Args:
        app: The application.
        allowed: Returns the `Allow` header of a path.
        many_sites: Whether sites are below `/sites/{site}`, where a client may have meant to ask.
    """
    app.exception_handler(GatewayError)(_gateway_error)
    app.add_middleware(ExceptionMiddleware, handlers={GatewayError: _gateway_error})  # type: ignore[dict-item]

    @app.exception_handler(RequestValidationError)
    async def validation_error(request: Request, error: RequestValidationError) -> Response:
        return _answer(request, InvalidField([_field_error(item) for item in error.errors()[:20]]))

    @app.exception_handler(HTTPException)
    async def http_error(request: Request, error: HTTPException) -> Response:
        status, headers, detail = HTTPStatus(error.status_code), dict(error.headers or {}), str(error.detail)
        path = request.scope["path"]
        if status is HTTPStatus.METHOD_NOT_ALLOWED:
            headers["Allow"] = allowed(path) or headers.get("Allow", "")
            if request.method == "OPTIONS":
                return Response(status_code=HTTPStatus.NO_CONTENT, headers=headers)
            detail = f"{request.method[:20]} is not a method of {path[:200]!r}; it has {headers['Allow']}"
        elif status is HTTPStatus.NOT_FOUND and path.endswith("/") and allowed(without := path.rstrip("/")):
            # With a body: a client that does not follow it must not look as if it had done something.
            status, detail = HTTPStatus.TEMPORARY_REDIRECT, f"there is no slash at the end: the path is {without[:200]}"
            headers["Location"] = str(URL(path=quote(without), query=request.url.query))
        elif status is HTTPStatus.NOT_FOUND:
            detail = f"there is nothing at {path[:200]!r}; /docs lists the API"
            if many_sites:
                detail += ", and what belongs to one site is at /sites/{site}/…"
        problem = GatewayError(detail, code=CODES.get(status, "malformed_request"), status=status)
        response = _answer(request, problem)
        response.headers.update(headers)
        return response

    @app.exception_handler(Exception)
    async def bug(_: Request, __: Exception) -> Response:  # uvicorn logs the traceback
        return problem_response(INTERNAL)


def _answer(connection: HTTPConnection, error: GatewayError) -> Response:
    """Return the answer for an error, and note its code for the audit log."""
    connection.scope["problem"] = error.code
    return problem_response(error)


async def _gateway_error(connection: Request | WebSocket, error: Exception) -> Response | None:
    """Answer a request, or refuse a WebSocket that has not been accepted yet."""
    assert isinstance(error, GatewayError)
    response = _answer(connection, error)
    if isinstance(connection, Request):
        return response
    await connection.send_denial_response(response)
    return None


def _field_error(item: dict[str, Any]) -> FieldError:
    """Return an error of FastAPI, of a parameter: `loc` begins with the part of the request that has it.

    A parameter may be repeated; which of them it was, `got` says.
    """
    place, *path = item["loc"]
    path = [part for part in path if not isinstance(part, int)]
    missing = item["type"] == "missing"
    return FieldError(
        ".".join(map(str, path)),
        "a value" if missing else expectation(item),
        "it is missing" if missing else got(item.get("input"), 60),
        place,
    )
