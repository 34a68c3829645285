"""`/extensions`: which extensions there are, and what those of other distributions add to the dashboard."""

from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as PathParameter
from starlette.responses import FileResponse, Response

from dock_gateway.core.errors import NotFound
from dock_gateway.core.grant import Role
from dock_gateway.extension import Installed
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.schema import Schema

router = APIRouter(route_class=ApiRoute, tags=["Extensions"], prefix="/extensions")

JAVASCRIPT = "text/javascript"
NamePath = Annotated[str, PathParameter(pattern="^[a-z][a-z0-9_]{0,59}$")]


class ExtensionInfo(Schema):
    """An extension.

    `card` is the path of an ES module that defines the custom element `NAME-card`, with `-` instead of `_`, which the
    dashboard shows on a robot's page with the attribute `robot`; null if it has none.
    """

    name: str
    card: str | None


class ExtensionList(Schema):
    """The extensions of this gateway."""

    extensions: list[ExtensionInfo]


@router.get("")
@operation(Role.VIEWER, Scope.ANY, Audit.NEVER)
async def list_extensions(installed: Part[Installed]) -> Answer[ExtensionList]:
    """List the extensions of this gateway, also those that could not be opened: the alerts name them."""
    cards = {each.name for each in installed if each.card is not None}
    documents = [
        {"name": name, "card": f"/extensions/{name}/card.js" if name in cards else None} for name in installed.names
    ]
    return json_response({"extensions": documents})


@router.get(
    "/{name}/card.js",
    responses={200: {"description": "The ES module", "content": {JAVASCRIPT: {}}}},
    response_class=Response,
)
@operation(Role.VIEWER, Scope.ANY, Audit.NEVER, errors=(404,))
async def get_card(name: NamePath, installed: Part[Installed]) -> Response:
    """Return the ES module of an extension's card."""
    for each in installed:
        if each.name == name and each.card is not None:
            return FileResponse(each.card, media_type=JAVASCRIPT, headers={"Cache-Control": "no-cache"})
    raise NotFound(f"there is no card of an extension {name}", code="extension_not_found")
