"""`/map`: the map of a robot, and its image."""

import re
from collections.abc import AsyncGenerator, Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from dock_gateway.core.errors import NotFound, not_covered
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.maps.image import COLORS, Color, image
from dock_gateway.extensions.maps.schema import RobotMap
from dock_gateway.extensions.maps.service import Maps
from dock_gateway.extensions.maps.surroundings import Surroundings
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import Answer, RobotQuery, is_known_tag, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.slow_clients import PacedResponse
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings

router = APIRouter(route_class=ApiRoute, tags=["Maps"])

# Bytes that are sent at once.
CHUNK = 65_536
COLOR = re.compile("[0-9a-fA-F]{6}(?:[0-9a-fA-F]{2})?")
ColorQuery = Annotated[str | None, Query(pattern=f"^{COLOR.pattern}$", description="`RRGGBB`, or `RRGGBBAA`")]
PNG: dict[int | str, dict[str, Any]] = {
    200: {"description": "The image, the top row first", "content": {"image/png": {}}},
    304: {"description": "As in `If-None-Match`"},
}


@router.get("/map")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_map(
    maps: Part[Maps], robots: Part[RobotRegistry], grant: TheGrant, robot: RobotQuery = None
) -> Answer[RobotMap]:
    """Return the newest map of a robot, without its cells: its size, its frame, and how the robot's relates to that."""
    view = await _view(maps, robots, grant, robot)
    return json_response(view.map_document())


@router.get("/map.png", response_class=Response, responses={**PNG}, openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_map_image(
    request: Request,
    maps: Part[Maps],
    robots: Part[RobotRegistry],
    grant: TheGrant,
    *,
    settings: Part[Settings],
    robot: RobotQuery = None,
    free: ColorQuery = None,
    occupied: ColorQuery = None,
    unknown: ColorQuery = None,
) -> Response:
    """Return the newest map of a robot as an image: a pixel for each cell, which is transparent where unknown.

    `free`, `occupied` and `unknown` are other colours for it. With `If-None-Match`, return 304 if it has not changed.
    """
    view = await _view(maps, robots, grant, robot)
    encoded = None if view.feed is None else await view.feed.image()
    if encoded is None:
        raise NotFound("there is no map any more", code="map_not_found")
    grid, pixels = encoded
    colors = _read_color(free, COLORS[0]), _read_color(occupied, COLORS[1]), _read_color(unknown, COLORS[2])
    shade = "".join("".join(f"{part:02x}" for part in color) for color in colors)
    tag = f'"{grid.revision}-{shade}"'
    headers = {"ETag": tag, "Cache-Control": "no-cache"}
    if is_known_tag(request.headers.get("if-none-match"), tag):
        return Response(status_code=304, headers=headers)
    height, width = grid.cells.shape
    pieces = image(pixels, width, height, colors)
    headers["Content-Length"] = str(sum(map(len, pieces)))
    timeout = settings.subscriber_timeout
    return PacedResponse(pieces[0], _chunks(pieces[1:]), timeout, media_type="image/png", headers=headers)


async def _chunks(pieces: Sequence[bytes]) -> AsyncGenerator[bytes]:
    """Yield what is next when the client has taken what was before: a slow one does not hold a copy of a large map."""
    for piece in pieces:
        for at in range(0, len(piece), CHUNK):
            yield piece[at : at + CHUNK]


async def _view(maps: Maps, robots: RobotRegistry, grant: Grant, robot: str | None) -> Surroundings:
    view = await maps.surroundings(robots.get(robot).namespace)
    if view.feed is not None and not grant.shows(view.feed.topic):
        raise not_covered(f"the topic {view.feed.topic}")
    return view


def _read_color(text: str | None, default: Color) -> Color:
    if text is None:
        return default
    red, green, blue, opacity = bytes.fromhex(text.ljust(8, "f"))
    return red, green, blue, opacity
