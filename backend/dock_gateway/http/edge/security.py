"""Security headers for browsers. Every answer has them, whichever part made it."""

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as ConnectionScope

CONTENT_SECURITY_POLICY = "Content-Security-Policy"
_NO_FRAMES = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
# The policy for data: nothing in it is run, loaded or framed. Pages set the policy below.
_DATA_POLICY = f"default-src 'none'; {_NO_FRAMES}"
PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    f"font-src 'self' data:; connect-src 'self'; manifest-src 'self'; {_NO_FRAMES}"
)
SECURITY_HEADERS = {
    CONTENT_SECURITY_POLICY: _DATA_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
# No cache keeps an answer, which may be for one user alone, unless it says otherwise.
NO_STORE = {"Cache-Control": "no-store"}
# For a year, browsers use HTTPS only with this host name, on every port. They ignore it for IP addresses.
HSTS = {"Strict-Transport-Security": "max-age=31536000"}


def security_headers(*, tls: bool) -> dict[str, str]:
    """Return the headers of an answer.

    Args:
        tls: Whether the gateway itself speaks TLS. Behind a proxy that does, HSTS is up to the proxy.
    """
    return SECURITY_HEADERS | HSTS if tls else SECURITY_HEADERS


class SecurityHeaders:
    """ASGI middleware that adds the headers that an answer does not have already."""

    def __init__(self, app: ASGIApp, *, tls: bool = False) -> None:
        self._app = app
        self._headers = security_headers(tls=tls) | NO_STORE

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on, and add the headers to the answer."""

        async def send_with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = MutableHeaders(scope=message)
                for name, value in self._headers.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, send_with_headers)
