"""The methods of each path, for `OPTIONS` and 405 responses, and `HEAD` wherever there is `GET`."""

from collections.abc import Callable, Iterable, Sequence

from starlette.routing import BaseRoute, Route
from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as ConnectionScope

AllowedMethods = Callable[[str], str | None]


def allowed_methods(routes: Sequence[BaseRoute]) -> AllowedMethods:
    """Return a function that maps a path to its `Allow` header, or to None if it has no route.

    Starlette's router reports only the methods of the first route whose path matches. The methods of a path are those
    of all routes with the same template.
    """
    found: list[Route] = [route for route in routes if isinstance(route, Route)]

    def allowed(path: str) -> str | None:
        template = next((route.path for route in found if route.path_regex.match(path)), None)
        if template is None:
            return None
        return _join(route.methods or () for route in found if route.path == template)

    return allowed


def _join(methods: Iterable[Iterable[str]]) -> str:
    found = {"OPTIONS"}.union(*methods)
    return ", ".join(sorted(found | {"HEAD"} if "GET" in found else found))


class HeadAsGet:
    """ASGI middleware that answers `HEAD` with the head of the answer to `GET` (RFC 9110, 9.3.2).

    What is inside takes the request for a `GET`: its role, its quotas, the audit log and the metrics are those of
    `GET`. With the head the answer is complete, so a stream ends like one whose client has gone.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return
        complete = False

        async def send_head(message: Message) -> None:
            nonlocal complete
            if complete:
                return
            if message["type"] == "http.response.body":
                complete = True
                message = {"type": "http.response.body", "body": b""}
            await send(message)

        await self._app({**scope, "method": "GET"}, receive, send_head)
