"""`/tokens`: tokens of those who use the gateway."""

from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request
from starlette.responses import Response

from dock_gateway.access.credentials import ID_DIGITS
from dock_gateway.access.schema import CreatedToken, TokenList
from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import LIMITS, Grant
from dock_gateway.http.audit_trail import audited
from dock_gateway.http.fields import GRANT_REQUEST, read_grant
from dock_gateway.http.openapi import body
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    TheGateway,
    json_response,
    known_query,
    name_schema,
    read_json,
    read_name,
    read_object,
)

router = APIRouter(tags=["Access"], prefix="/tokens", dependencies=[Depends(known_query())])

MAX_NAME, MAX_DAYS = 60, 3650
TOKEN_REQUEST = {
    "type": "object",
    "required": ["name", "role"],
    "additionalProperties": False,
    "properties": {
        "name": name_schema(MAX_NAME) | {"description": "Who uses it: a person or a script"},
        **GRANT_REQUEST,
        "days": {
            "type": ["integer", "null"],
            "minimum": 1,
            "maximum": MAX_DAYS,
            "description": "For how long it is valid; null: until it is revoked",
        },
    },
    "examples": [{"name": "night shift script", "role": "operator", "robots": ["/hall_a/*"], "days": 90}],
}
TokenId = Annotated[str, Path(json_schema_extra={"pattern": f"^[0-9a-f]{{{ID_DIGITS}}}$"})]


@router.get("", name="list_tokens", response_model=TokenList, responses=problems(401, 403, 422, 503))
async def list_tokens(gateway: TheGateway) -> Response:
    """List all tokens by name, without their secrets."""
    return json_response({"tokens": await gateway.logins.tokens.documents()})


@router.post(
    "",
    name="create_token",
    status_code=201,
    response_model=CreatedToken,
    responses=problems(400, 401, 403, 408, 409, 413, 415, 422, 503),
    openapi_extra=body(TOKEN_REQUEST, required=True),
)
async def create_token(request: Request, gateway: TheGateway) -> Response:
    """Create a token. Only this answer has its secret."""
    name, grant, expires_at = read_token(await read_json(request))
    audited(request, subject=name)
    token, secret = await gateway.logins.create_token(name, grant, expires_at, principal_of(request).name)
    return json_response({**token, "secret": secret}, 201, {"Cache-Control": "no-store"})


@router.delete("/{token_id}", name="revoke_token", status_code=204, responses=problems(401, 403, 404, 422, 503))
async def revoke_token(token_id: TokenId, request: Request, gateway: TheGateway) -> Response:
    """Revoke a token: requests with it are refused, and its streams end, at other gateways within 2 s."""
    audited(request, subject=gateway.logins.tokens.name_of(token_id) or token_id)
    await gateway.logins.revoke_token(token_id)
    return Response(status_code=204)


def read_token(value: Any) -> tuple[str, Grant, datetime | None]:
    """Return the name, the grant and the expiry of a token from a decoded body.

    Raises:
        InvalidField: It is not a token.
    """
    fields = read_object(value, "name", "role", *LIMITS, "days")
    grant, days = read_grant(fields), fields.get("days")
    if days is not None and (type(days) is not int or not 0 < days <= MAX_DAYS):
        raise InvalidField([FieldError("days", f"1 to {MAX_DAYS} days, or null", got(days))])
    expires_at = None if days is None else utc_now() + timedelta(days=days)
    return read_name(fields.get("name"), MAX_NAME, "name"), grant, expires_at
