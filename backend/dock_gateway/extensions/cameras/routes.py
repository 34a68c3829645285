"""`/cameras`: the cameras of a robot, their pictures, and streams of them."""

from collections.abc import AsyncGenerator
from contextlib import aclosing
from typing import Annotated

from fastapi import APIRouter, Query, Request
from starlette.responses import Response, StreamingResponse

from dock_gateway.access.authorization import subscribed
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import Role
from dock_gateway.extensions.cameras.camera import Camera
from dock_gateway.extensions.cameras.cameras import Cameras
from dock_gateway.extensions.cameras.picture import BOUNDARY, JPEG, PNG
from dock_gateway.extensions.cameras.schema import CameraList
from dock_gateway.http.edge.http import limit_unsent
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts, Part, Parts
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.requests import Answer, GraphName, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.slow_clients import PacedResponse
from dock_gateway.settings import Settings

router = APIRouter(route_class=ApiRoute, tags=["Cameras"], prefix="/cameras")

MIXED = "multipart/x-mixed-replace"
PICTURES: dict[str, dict[str, str]] = {JPEG: {}, PNG: {}}
# Bytes that the system holds for a viewer that reads slowly: about one picture.
UNSENT = 32_768

WidthQuery = Annotated[int | None, Query(ge=16, le=8192, description="Maximum width in pixels; JPEG only")]
RateQuery = Annotated[float | None, Query(ge=0.1, le=60, description="Maximum number of pictures per second")]


@router.get("")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def list_cameras(cameras: Part[Cameras], grant: TheGrant, robot: RobotQuery = None) -> Answer[CameraList]:
    """List the cameras of a robot: topics of CompressedImage and Image in its namespace that have a publisher."""
    found = await cameras.all(robot, grant)
    documents = [
        {"name": camera.name, **cameras.form(camera)._asdict(), "hint": cameras.hint(camera)} for camera in found
    ]
    return json_response({"cameras": documents})


@router.get(
    "/{name:graph_name}/image",
    responses={200: {"description": "The picture", "content": PICTURES}},
    response_class=Response,
)
@operation(Role.VIEWER, Scope.ROBOT, errors=(404, 429, 502))
async def get_picture(
    name: GraphName,
    parts: AllParts,
    principal: ThePrincipal,
    robot: RobotQuery = None,
    max_width: WidthQuery = None,
) -> Response:
    """Return one current picture of a camera. `X-Timestamp` says when it came, in seconds since 1970."""
    camera = await parts[Cameras].find(robot, name, principal.grant)
    with subscribed(parts, principal, EventFilter(topics=frozenset())) as viewer:
        async with aclosing(parts[Cameras].pictures(camera, viewer, max_width, None)) as pictures:
            async for picture in pictures:
                return Response(picture.data, headers={"X-Timestamp": picture.timestamp}, media_type=picture.media_type)
    raise Unavailable("the gateway is shutting down", code="shutting_down")


@router.get(
    "/{name:graph_name}/stream",
    responses={200: {"description": "Pictures", "content": {MIXED: {}}}},
    response_class=StreamingResponse,
)
@operation(Role.VIEWER, Scope.ROBOT, errors=(404, 429, 502))
async def stream_pictures(
    name: GraphName,
    request: Request,
    parts: AllParts,
    principal: ThePrincipal,
    *,
    robot: RobotQuery = None,
    max_rate: RateQuery = None,
    max_width: WidthQuery = None,
) -> Response:
    """Stream the pictures of a camera as MJPEG, which browsers show as an image. A slow reader skips pictures."""
    camera = await parts[Cameras].find(robot, name, principal.grant)
    limit_unsent(request, UNSENT)
    chunks = _chunks(parts, principal, camera, max_width, max_rate)
    first = await anext(chunks, b"")  # errors are raised before the stream begins
    media_type = f"{MIXED}; boundary={BOUNDARY}"
    headers = {"X-Accel-Buffering": "no"}
    return PacedResponse(first, chunks, parts[Settings].subscriber_timeout, media_type=media_type, headers=headers)


async def _chunks(
    parts: Parts, principal: Principal, camera: Camera, max_width: int | None, max_rate: float | None
) -> AsyncGenerator[bytes]:
    before = f"--{BOUNDARY}\r\n".encode()
    with subscribed(parts, principal, EventFilter(topics=frozenset())) as viewer:
        async with aclosing(parts[Cameras].pictures(camera, viewer, max_width, max_rate)) as pictures:
            async for picture in pictures:
                yield before + picture.part
                before = b""
