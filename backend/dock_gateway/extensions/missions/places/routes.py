"""`/places`: poses with a name, that missions drive to."""

from typing import Annotated

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.extensions.missions.places.place import Place, PlaceBody, PlaceList
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import SLUG_IN_PATH, Answer, json_response, read_slug
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Missions"], prefix="/places")


async def _place_id_in_path(place_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(place_id, "place_id")


PlaceId = Annotated[str, Depends(_place_id_in_path)]


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ANY)
async def list_places(places: Part[Places]) -> Answer[PlaceList]:
    """List the places that missions drive to, by id."""
    return json_response({"places": await places.documents()})


@router.get("/{place_id}", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ANY, errors=(404,))
async def get_place(place_id: PlaceId, places: Part[Places]) -> Item[Place]:
    """Return a place."""
    return item_response(await places.document(place_id))


@router.put("/{place_id}", openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def replace_place(
    place_id: PlaceId, body: SignedBody[PlaceBody], places: Part[Places], condition: WriteCondition
) -> Item[Place]:
    """Store a place, new or changed, at every gateway that shares the history.

    Missions that are queued drive to where it is when their step begins.
    """
    place, new = await places.replace(place_id, body.entry(), condition)
    return item_response(place, f"{router.prefix}/{place_id}" if new else None)


@router.delete("/{place_id}", status_code=204, openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_place(place_id: PlaceId, places: Part[Places], condition: ChangeCondition) -> Response:
    """Remove a place. A step that drives to it fails when it begins."""
    return await removed(places.remove(place_id, condition))
