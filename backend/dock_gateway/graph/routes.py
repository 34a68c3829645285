"""`/graph`: nodes, topics, services and actions on the ROS graph."""

from fastapi import APIRouter, Request
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.schema import Graph, GraphTopic
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import Answer, GraphName, is_known_tag, json_response
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Graph"], prefix="/graph")


@router.get("", response_model=Graph, responses={304: {"description": "As in `If-None-Match`"}})
@operation(Role.VIEWER, Scope.LISTED)
async def get_graph(request: Request, graph: Part[GraphCache], grant: TheGrant) -> Response:
    """Return the graph, at most one second old. With `If-None-Match`, return 304 if it has not changed."""
    view = await graph.graph(grant)
    headers = {"ETag": view.tag, "Cache-Control": "no-cache"}
    if is_known_tag(request.headers.get("if-none-match"), view.tag):
        return Response(status_code=304, headers=headers)
    return Answer(view.body, headers=headers)


@router.get("/topics/{name:graph_name}")
@operation(Role.VIEWER, Scope.TOPIC)
async def get_topic(name: GraphName, graph: Part[GraphCache]) -> Answer[GraphTopic]:
    """Return the current state of one topic, with its publishers and subscribers."""
    return json_response((await graph.topic(f"/{name}")).document())
