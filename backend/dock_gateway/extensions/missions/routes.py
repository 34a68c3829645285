"""`/missions`: what robots do, one thing after the other."""

import uuid
from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.extensions.missions.mission import MissionStatus
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.schema import MISSION_ID, Mission, MissionBody, MissionList, MoveBody
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.http.bodies import Body, SignedBody
from dock_gateway.http.openapi import IDEMPOTENCY_KEY, UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant, read_own_key
from dock_gateway.http.queries import TIME_PATTERN, Time
from dock_gateway.http.requests import (
    Answer,
    AnyRobotQuery,
    CursorQuery,
    LimitQuery,
    RobotQuery,
    end_of_page,
    json_response,
)
from dock_gateway.http.resource import ETAG_HEADER, LOCATION_HEADER, ChangeCondition, Item, item_response
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Missions"], prefix="/missions")

MissionId = Annotated[str, Path(description="`mission_id`", json_schema_extra={"pattern": MISSION_ID})]
OwnKey = Annotated[str | None, Depends(read_own_key)]
StatusQuery = Annotated[list[MissionStatus] | None, Query(description="Only missions in these states")]
NotEndedQuery = Annotated[
    Time | None,
    Query(description="Only missions that had not ended before this time, RFC 3339", json_schema_extra=TIME_PATTERN),
]


def id_of(key: str | None) -> str:
    """Return the id of a new mission: the same one for the same key of the same client."""
    return uuid.uuid4().hex if key is None else uuid.uuid5(uuid.NAMESPACE_OID, f"mission {key}").hex


@router.post(
    "",
    status_code=201,
    responses={201: {"headers": ETAG_HEADER | LOCATION_HEADER}},
    openapi_extra=UNSTABLE | {"parameters": [IDEMPOTENCY_KEY]},
)
@operation(Role.AGENT, Scope.LISTED, errors=(404, 409, 421))
async def create_mission(
    body: SignedBody[MissionBody],
    request: Request,
    *,
    missions: Part[Missions],
    grant: TheGrant,
    key: OwnKey,
    robot: RobotQuery = None,
) -> Answer[Mission]:
    """Queue a mission for a robot, or with `group` for the robot of that group that is free and has the most charge.

    It begins when no other one of the robot is on its way, and none comes first.

    One of an agent that moves a real robot is `held` for `approval`: it begins after an operator has continued it.

    With the same `Idempotency-Key`, a request that is sent twice makes one mission.
    """
    mission_id = id_of(key)
    document = await missions.add(mission_id, body, robot, grant)
    audited(request, robot=document["robot"], subject=mission_id)
    headers = {"Location": f"{router.prefix}/{mission_id}", "ETag": document["etag"]}
    return json_response(document, 201, headers)


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def list_missions(
    missions: Part[Missions],
    known_robots: Part[KnownRobots],
    grant: TheGrant,
    *,
    robot: AnyRobotQuery = None,
    status: StatusQuery = None,
    since: NotEndedQuery = None,
    limit: LimitQuery = 50,
    cursor: CursorQuery = None,
) -> Answer[MissionList]:
    """List the missions, newest first: those that have not ended, and the last 1000 that have."""
    await known_robots.require(robot, grant, missions.book.has)
    namespace = None if robot is None else read_namespace(robot)
    statuses = frozenset(status or ())
    page, end = await missions.book.page(namespace, statuses, grant, limit, end_of_page(cursor), since=since)
    return json_response({"missions": page, "next_cursor": end and end.encode()})


@router.get("/{mission_id}", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_mission(mission_id: MissionId, missions: Part[Missions], grant: TheGrant) -> Item[Mission]:
    """Return a mission."""
    return item_response(await missions.book.document(mission_id, grant))


@router.put("/{mission_id}", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.LISTED, errors=(404, 409))
async def replace_mission(
    mission_id: MissionId,
    body: SignedBody[MissionBody],
    missions: Part[Missions],
    grant: TheGrant,
    condition: ChangeCondition,
) -> Item[Mission]:
    """Replace what a mission is to do that has not begun. It keeps its robot, and its place in the queue."""
    return item_response(await missions.replace(mission_id, body, grant, condition))


@router.post("/{mission_id}/move", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.LISTED, errors=(404, 409))
async def move_mission(
    mission_id: MissionId, body: Body[MoveBody], missions: Part[Missions], grant: TheGrant
) -> Item[Mission]:
    """Put a mission that has not begun right before or after another one of its queue, whose priority it gets."""
    other = body.before or body.after or ""
    return item_response(await missions.move(mission_id, other, grant, before=body.before is not None))


@router.post("/{mission_id}/cancel", openapi_extra=UNSTABLE)
@operation(Role.AGENT, Scope.LISTED, errors=(404, 409), stops=True)
async def cancel_mission(mission_id: MissionId, missions: Part[Missions], grant: TheGrant) -> Answer[Mission]:
    """End a mission. The goal of its step is canceled first, which `canceling` shows."""
    return json_response(await missions.cancel(mission_id, grant))


@router.post("/{mission_id}/pause", openapi_extra=UNSTABLE)
@operation(Role.AGENT, Scope.LISTED, errors=(404, 409))
async def pause_mission(mission_id: MissionId, missions: Part[Missions], grant: TheGrant) -> Answer[Mission]:
    """Hold a mission before its next step, until it is continued."""
    return json_response(await missions.pause(mission_id, grant))


@router.post("/{mission_id}/continue", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.LISTED, errors=(404, 409))
async def continue_mission(mission_id: MissionId, missions: Part[Missions], grant: TheGrant) -> Answer[Mission]:
    """Let a mission that is held go on: with its step from the beginning, unless that waited for this.

    One that waits for a robot of a group may afterwards be begun by a robot that was stopped meanwhile.
    """
    return json_response(await missions.resume(mission_id, grant))


@router.post("/{mission_id}/skip", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.LISTED, errors=(404, 409))
async def skip_step(mission_id: MissionId, missions: Part[Missions], grant: TheGrant) -> Answer[Mission]:
    """Let a mission that is held go on without its step."""
    return json_response(await missions.skip(mission_id, grant))
