"""`/schedules`: missions that are queued by themselves, at times."""

from typing import Annotated

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.extensions.missions.schedules.schedule import MissionSchedule, MissionScheduleList, ScheduleBody
from dock_gateway.extensions.missions.schedules.schedules import Schedules
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import SLUG_IN_PATH, Answer, json_response, read_slug
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Missions"], prefix="/schedules")


async def _schedule_id_in_path(schedule_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(schedule_id, "schedule_id")


ScheduleId = Annotated[str, Depends(_schedule_id_in_path)]


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED)
async def list_schedules(schedules: Part[Schedules], grant: TheGrant) -> Answer[MissionScheduleList]:
    """List the schedules, by id, each with its next time and what came of the last."""
    return json_response({"schedules": await schedules.documents(grant)})


@router.get("/{schedule_id}", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_schedule(schedule_id: ScheduleId, schedules: Part[Schedules], grant: TheGrant) -> Item[MissionSchedule]:
    """Return a schedule."""
    return item_response(await schedules.document(schedule_id, grant))


@router.put("/{schedule_id}", openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(404, 409))
async def replace_schedule(
    schedule_id: ScheduleId,
    body: SignedBody[ScheduleBody],
    schedules: Part[Schedules],
    grant: TheGrant,
    condition: WriteCondition,
) -> Item[MissionSchedule]:
    """Store a schedule, new or changed, at every gateway that shares the history. What was due before does not count.

    Its mission is checked as if it were queued now.
    """
    schedule, new = await schedules.replace(schedule_id, body, grant, condition)
    return item_response(schedule, f"{router.prefix}/{schedule_id}" if new else None)


@router.delete("/{schedule_id}", status_code=204, openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_schedule(schedule_id: ScheduleId, schedules: Part[Schedules], condition: ChangeCondition) -> Response:
    """Remove a schedule. Missions that it has queued go on."""
    return await removed(schedules.remove(schedule_id, condition))
