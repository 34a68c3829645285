"""Every request that the API has, by its routes."""

import re

from fastapi.routing import APIRoute

from dock_gateway.app import api_routers
from dock_gateway.extension import extensions
from dock_gateway.http.operation import operation_of
from dock_gateway.settings import Settings

ROUTES_OF_API = [route for router in api_routers(Settings(), extensions()) for route in router.routes]
REQUESTS = [
    (method, route.path, operation_of(route.endpoint))
    for route in ROUTES_OF_API
    if isinstance(route, APIRoute)
    for method in route.methods
]


def path_of(template: str) -> str:
    """Return a path that the route takes."""
    ids = "00000000-0000-4000-8000-000000000000"
    return re.sub(r"\{(\w+)(:\w+)?\}", lambda match: ids if match[1] == "goal_id" else "x1", template)
