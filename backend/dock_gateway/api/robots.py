"""`/robots`: every robot on the graph at a glance."""

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.api.answers import RobotQuery, TheGateway, json_response
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query
from dock_gateway.api.schemas import RobotList

router = APIRouter(tags=["Robots"], prefix="/robots", dependencies=[Depends(known_query("robot"))])


@router.get("", response_model=RobotList, responses=problems(404, 422))
async def list_robots(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Every robot that was found, or the one that is asked for."""
    return json_response({"robots": gateway.fleet.documents(robot)})
