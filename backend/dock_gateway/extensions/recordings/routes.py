"""`/goals/…/recording.mcap` and `/recording.mcap`: what was heard of a robot, as files of MCAP."""

import contextlib
from collections.abc import AsyncGenerator
from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Request
from starlette.datastructures import Headers
from starlette.responses import FileResponse, Response
from starlette.types import Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, InvalidField, NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Role
from dock_gateway.extensions.recordings.recordings import Recordings
from dock_gateway.extensions.recordings.schema import GoalReplay
from dock_gateway.goals.goals import Goals
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.requests import Answer, GoalId, RobotQuery, is_known_tag, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.slow_clients import PacedResponse, send_in_time
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings

router = APIRouter(route_class=ApiRoute)

MCAP = "application/x-mcap"
# Bytes that are sent at once.
PIECE = 65_536
FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "A file", "content": {MCAP: {"schema": {"type": "string", "format": "binary"}}}}
}
RANGES: dict[int | str, dict[str, Any]] = {
    **FILE,
    206: {**FILE[200], "description": "A part of the file, as `Range` asks for"},
    304: {"description": "The client has it, as `If-None-Match` says"},
}
PICTURE: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "A picture",
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in ("image/jpeg", "image/png")},
    }
}


class RecordingResponse(FileResponse):
    """A file, whole or in ranges, that cuts off a client that does not read. It counts as one of the user's exports."""

    def __init__(self, principal: Principal, timeout: float, quotas: Quotas, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._slot = quotas.slot(principal, "exports")
        self._timeout = timeout

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Send the file.

        Raises:
            InvalidField: The file has no such range.
        """
        asked = Headers(scope=scope).get("range", "")
        left = 0  # bytes that are announced and not sent
        with_body = scope["method"] != "HEAD"

        async def send_on(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] >= HTTPStatus.BAD_REQUEST:
                raise InvalidField([FieldError("range", "a range of the file", f"got {asked[:60]!r}", "header")])
            nonlocal left
            if message["type"] == "http.response.start":
                left = int(Headers(raw=message["headers"])["content-length"])
            left -= len(message.get("body", b""))
            if message["type"] == "http.response.body" and not message.get("more_body") and left and with_body:
                raise FileNotFoundError("it has been cut off meanwhile")
            await send_in_time(send, message, self._timeout)

        with self._slot, contextlib.suppress(TimeoutError, FileNotFoundError):
            await super().__call__(scope, receive, send_on)


class PartResponse(PacedResponse):
    """A file that was made for one user, sent in pieces. It counts as one of their exports until it has been sent."""

    def __init__(self, principal: Principal, timeout: float, quotas: Quotas, data: memoryview, name: str) -> None:
        headers = {"Content-Disposition": f'attachment; filename="{name}"', "Content-Length": str(len(data))}
        super().__init__(b"", _pieces(data), timeout, media_type=MCAP, headers=headers)
        self._slot = quotas.slot(principal, "exports")

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Send the file.

        Raises:
            TooManyRequests: The user has too many exports (`too_many_exports`).
        """
        with self._slot:
            await super().__call__(scope, receive, send)


async def _pieces(data: memoryview) -> AsyncGenerator[bytes]:
    for at in range(0, len(data), PIECE):
        yield bytes(data[at : at + PIECE])


@router.get("/goals/{goal_id}/recording.mcap", tags=["Goals"], response_class=Response, responses={**RANGES})
@operation(Role.VIEWER, Scope.GOAL, Audit.ALWAYS, errors=(429,))
async def download_recording(
    request: Request,
    goal_id: GoalId,
    goals: Part[Goals],
    *,
    recordings: Part[Recordings],
    settings: Part[Settings],
    quotas: Part[Quotas],
    principal: ThePrincipal,
) -> Response:
    """Download what was heard of the robot from 5 s before a goal to 2 s after its end, as MCAP.

    Without a recording, `recording_not_found` says why. With an access to some robots, actions or topics, the file has
    only their topics. Ranges are supported where it has all.
    """
    found = await recordings.find(await goals.get(goal_id))
    name = f"goal-{goal_id}.mcap"
    grant = principal.grant
    if grant.limited or grant.topics:
        with quotas.slot(principal, "exports"):
            data = await recordings.narrowed(found, grant)
        return PartResponse(principal, settings.subscriber_timeout, quotas, data, name)
    tag = f'"{found.goal_id}-{found.size}-{int(found.at * 1e6)}"'
    headers = {"Cache-Control": "no-cache", "ETag": tag}
    if is_known_tag(request.headers.get("if-none-match"), tag):
        return Response(status_code=304, headers=headers)
    try:
        stat = found.path.stat()
    except FileNotFoundError:
        raise NotFound("It has just been deleted.", code="recording_not_found") from None
    return RecordingResponse(
        principal,
        settings.subscriber_timeout,
        quotas,
        found.path,
        headers=headers,
        media_type=MCAP,
        filename=name,
        stat_result=stat,
    )


@router.get("/goals/{goal_id}/replay", tags=["Goals"], openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.GOAL)
async def get_replay(
    goal_id: GoalId,
    goals: Part[Goals],
    recordings: Part[Recordings],
    *,
    robots: Part[RobotRegistry],
    settings: Part[Settings],
    grant: TheGrant,
) -> Answer[GoalReplay]:
    """Return what the replay of a goal shows of its recording: laser scans, commanded velocities, battery, the log."""
    goal = await goals.get(goal_id)
    owner = robots.owner(goal.action_name)
    found = await recordings.replay(
        await recordings.find(goal),
        goal,
        grant,
        velocity=settings.cmd_vel_topic.rpartition("/")[2],
        robot=goal.action_name.rpartition("/")[0] if owner is None else owner.namespace,
    )
    return json_response(found)


@router.get(
    "/goals/{goal_id}/thumbnail", tags=["Goals"], response_class=Response, responses={**PICTURE}, openapi_extra=UNSTABLE
)
@operation(Role.VIEWER, Scope.GOAL)
async def get_thumbnail(goal_id: GoalId, goals: Part[Goals], recordings: Part[Recordings], grant: TheGrant) -> Response:
    """Return the last picture of the robot's camera in the recording of a goal."""
    found = await recordings.find(await goals.get(goal_id))
    data, media_type = await recordings.picture(found, grant)
    return Response(data, media_type=media_type, headers={"Cache-Control": "private, max-age=3600"})


@router.get("/recording.mcap", tags=["Robots"], response_class=Response, responses={**FILE})
@operation(Role.VIEWER, Scope.ROBOT, Audit.ALWAYS, errors=(404, 429))
async def download_recent(
    request: Request,
    robots: Part[RobotRegistry],
    recordings: Part[Recordings],
    *,
    settings: Part[Settings],
    quotas: Part[Quotas],
    principal: ThePrincipal,
    robot: RobotQuery = None,
) -> Response:
    """Download what has been heard of a robot in the last seconds, as MCAP: someone has just seen something odd."""
    namespace = robots.get(robot).namespace
    with quotas.slot(principal, "exports"):
        data = await recordings.of_robot(namespace, principal.grant)
    name = namespace.strip("/").replace("/", "-") or "robot"
    file = f"{name}-{utc_now():%Y%m%dT%H%M%SZ}.mcap"
    return PartResponse(principal, settings.subscriber_timeout, quotas, data, file)
