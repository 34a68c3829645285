"""`/mission-templates`: missions with parameters."""

from typing import Annotated

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.extensions.missions.templates.template import Template, TemplateBody, TemplateList
from dock_gateway.extensions.missions.templates.templates import Templates
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import SLUG_IN_PATH, Answer, json_response, read_slug
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Missions"], prefix="/mission-templates")


async def _template_id_in_path(template_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(template_id, "template_id")


TemplateId = Annotated[str, Depends(_template_id_in_path)]


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED)
async def list_templates(templates: Part[Templates], grant: TheGrant) -> Answer[TemplateList]:
    """List the templates, by id: `POST /missions` makes missions of them."""
    return json_response({"templates": await templates.documents(grant)})


@router.get("/{template_id}", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_template(template_id: TemplateId, templates: Part[Templates], grant: TheGrant) -> Item[Template]:
    """Return a template."""
    return item_response(await templates.document(template_id, grant))


@router.put("/{template_id}", openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def replace_template(
    template_id: TemplateId, body: SignedBody[TemplateBody], templates: Part[Templates], condition: WriteCondition
) -> Item[Template]:
    """Store a template, new or changed, at every gateway that shares the history.

    Missions that were made of it before stay as they are.
    """
    template, new = await templates.replace(template_id, body.entry(), condition)
    return item_response(template, f"{router.prefix}/{template_id}" if new else None)


@router.delete("/{template_id}", status_code=204, openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_template(template_id: TemplateId, templates: Part[Templates], condition: ChangeCondition) -> Response:
    """Remove a template. Missions that were made of it go on."""
    return await removed(templates.remove(template_id, condition))
