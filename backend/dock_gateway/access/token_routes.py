"""`/tokens`: tokens of those who use the gateway."""

from datetime import timedelta
from typing import Annotated

from fastapi import APIRouter, Path, Request
from starlette.responses import Response

from dock_gateway.access.credentials import ID_DIGITS
from dock_gateway.access.logins import Logins
from dock_gateway.access.schema import CreatedToken, Token, TokenBody, TokenList
from dock_gateway.audit.trail import audited
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Role
from dock_gateway.http.bodies import Body
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import ThePrincipal
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.resource import ChangeCondition, Item, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Access"], prefix="/tokens")

TokenId = Annotated[str, Path(pattern=f"^[0-9a-f]{{{ID_DIGITS}}}$")]


@router.get("", name="list_tokens")
@operation(Role.ADMIN, Scope.EVERY)
async def list_tokens(logins: Part[Logins]) -> Answer[TokenList]:
    """List all tokens by name, without their secrets."""
    return json_response({"tokens": await logins.tokens.documents()})


@router.post("", name="create_token", status_code=201)
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST, errors=(409,))
async def create_token(
    body: Body[TokenBody], request: Request, logins: Part[Logins], principal: ThePrincipal
) -> Item[CreatedToken]:
    """Create a token. Only this answer has its secret."""
    audited(request, subject=body.name)
    expires_at = None if body.days is None else utc_now() + timedelta(days=body.days)
    token, secret = await logins.create_token(body.name, body.grant(), expires_at, principal.name)
    document = {**token, "secret": secret}
    return item_response(document, f"{router.prefix}/{token['id']}", {"Cache-Control": "no-store"})


@router.get("/{token_id}", name="get_token")
@operation(Role.ADMIN, Scope.EVERY, errors=(404,))
async def get_token(token_id: TokenId, logins: Part[Logins]) -> Item[Token]:
    """Return a token, without its secret."""
    return item_response(await logins.tokens.document(token_id))


@router.delete("/{token_id}", name="revoke_token", status_code=204)
@operation(Role.ADMIN, Scope.EVERY, Audit.STORED_FIRST)
async def revoke_token(
    token_id: TokenId, request: Request, logins: Part[Logins], condition: ChangeCondition
) -> Response:
    """Revoke a token: requests with it are refused, and its streams end, at other gateways within 2 s."""
    audited(request, subject=logins.tokens.name_of(token_id) or token_id)
    return await removed(logins.revoke_token(token_id, condition))
