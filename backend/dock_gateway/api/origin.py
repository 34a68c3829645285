"""Who may speak to the gateway from inside a browser.

A page of another site must not move the robot behind its user's back: neither by a form or a script (Origin), nor by a
name that it lets point to this machine (Host, DNS rebinding). Programs that are not browsers send no Origin and pass.
"""

from ipaddress import ip_address
from urllib.parse import SplitResult, urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket

from dock_gateway.api.problems import problem_response
from dock_gateway.errors import GatewayError, NotAllowed
from dock_gateway.settings import LOOPBACK_HOSTS, Settings

# OPTIONS is not among them: a preflight is answered (CORS) to the pages that are allowed.
SAFE_METHODS = frozenset({"GET", "HEAD"})


class OriginGuard:
    """ASGI middleware that refuses requests of foreign pages and to foreign host names."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self._app = app
        self._hosts = LOOPBACK_HOSTS.union(settings.allowed_hosts)
        self._origins = frozenset(settings.allowed_origins)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer 403."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            self._check(scope)
        except GatewayError as error:
            response = problem_response(error)
            if scope["type"] == "websocket":
                await WebSocket(scope, receive, send).send_denial_response(response)
            else:
                await response(scope, receive, send)
            return
        await self._app(scope, receive, send)

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = _split(f"//{host}").hostname or ""
        if not ({name, "*"} & self._hosts or _is_address(name)):
            raise NotAllowed(
                f"this gateway does not answer to the name {name[:100]!r}; DOCK_GATEWAY_ALLOWED_HOSTS can allow it",
                code="host_not_allowed",
            )
        origin = headers.get("origin")
        if origin is None or (scope["type"] == "http" and scope["method"] in SAFE_METHODS):
            return
        if "*" in self._origins or origin in self._origins or _split(origin).netloc == host:
            return
        raise NotAllowed(
            f"pages of {origin[:100]!r} may not use this gateway; DOCK_GATEWAY_ALLOWED_ORIGINS can allow them"
        )


def _is_address(name: str) -> bool:
    """Whether it is an IP address: nobody can let one point elsewhere."""
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


def _split(url: str) -> SplitResult:
    try:
        return urlsplit(url)
    except ValueError:  # such as a bracket that is not closed
        return SplitResult("", "", "", "", "")
