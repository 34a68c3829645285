"""A goal's short way in: past FastAPI, to the same function that FastAPI's routes call.

What FastAPI does for a request takes 0.1 ms while it is warm, and nearly 1 ms when the process has done nothing for a
while, which is when goals come. A plain submission needs none of it; whatever is not plain goes the long way.
"""

from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from dock_gateway.api import dock
from dock_gateway.api.actions import send_action_goal
from dock_gateway.api.problems import problem_response
from dock_gateway.api.requests import get_gateway
from dock_gateway.errors import GatewayError

VERBS = {verb.path: verb for verb in dock.VERBS}
ACTIONS, GOALS = "/actions/", "/goals"


class GoalShortcut:
    """ASGI middleware that answers `POST` to `/dock`, `/undock` and `/actions/…/goals` where there is no query.

    It goes where routes go: inside of everything that guards or logs requests.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the goal, or pass the request on."""
        if scope["type"] != "http" or scope["method"] != "POST" or scope["query_string"] or scope.get("root_path"):
            await self._app(scope, receive, send)
            return
        path: str = scope["path"]
        is_action = path.startswith(ACTIONS) and path.endswith(GOALS) and len(path) > len(ACTIONS) + len(GOALS)
        if path not in VERBS and not is_action:
            await self._app(scope, receive, send)
            return
        request = Request(scope, receive)
        try:
            response = await self._send_goal(path, request)
        except GatewayError as error:
            response = problem_response(error)
        await response(scope, receive, send)

    @staticmethod
    async def _send_goal(path: str, request: Request) -> Response:
        gateway = get_gateway(request)
        if (verb := VERBS.get(path)) is not None:
            return await verb.send_goal(request, gateway)
        return await send_action_goal(path[len(ACTIONS) : -len(GOALS)], request, gateway)
