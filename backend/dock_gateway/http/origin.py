"""Decides which web pages may use the gateway.

A page of another site must not move the robot without its user's knowledge: neither by a form or a script (Origin),
nor by a host name that it points to this machine (Host, DNS rebinding). Programs that are not browsers send no Origin
and pass.
"""

import logging
import re
from ipaddress import ip_address
from typing import NamedTuple

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.access import FORWARDED
from dock_gateway.core.errors import NotAllowed
from dock_gateway.setting_types import LOOPBACK_HOSTS
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# Without OPTIONS: preflights of allowed pages are answered by CORS.
SAFE_METHODS = frozenset({"GET", "HEAD"})
PORTS = {"http": 80, "https": 443}
# No user, no spaces, no empty parts, only numeric ports (RFC 9110, 7.2).
HOST = re.compile(r"(?P<name>[a-z0-9_.-]+|\[[0-9a-f:.]+\])(:(?P<port>[0-9]{1,5}))?")


class OriginGuard:
    """ASGI middleware that refuses requests from foreign pages and to foreign host names."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self._app = app
        self._hosts = LOOPBACK_HOSTS.union(settings.allowed_hosts)
        self._origins = frozenset(settings.allowed_origins)

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on.

        Raises:
            NotAllowed: The page or the host name is foreign.
        """
        if scope["type"] in ("http", "websocket") and FORWARDED not in scope:  # who forwards it has checked
            try:
                self._check(scope)
            except NotAllowed as error:
                if scope["type"] == "websocket":  # a page cannot see why
                    log.warning("a WebSocket was refused: %s", error.detail)
                raise
        await self._app(scope, receive, send)

    def _check(self, scope: ConnectionScope) -> None:
        headers = Headers(scope=scope)
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        address = _read_address(scope["scheme"].replace("ws", "http"), hosts[0]) if len(hosts) == 1 else None
        if address is None or not ({address.name, "*"} & self._hosts or _is_address(address.name)):
            raise NotAllowed(
                f"this gateway does not answer to the name {', '.join(hosts)[:100]!r}; "
                "DOCK_GATEWAY_ALLOWED_HOSTS can allow it",
                code="host_not_allowed",
            )
        if len(origins) < 2 and scope["type"] == "http" and scope["method"] in SAFE_METHODS:
            return
        if not origins and "cross-site" not in headers.getlist("sec-fetch-site"):
            return
        origin = origins[0].lower() if len(origins) == 1 else None
        if origin is not None and ("*" in self._origins or origin in self._origins or _read_origin(origin) == address):
            return
        raise NotAllowed(
            f"pages of {', '.join(origins)[:100] or 'another site'!r} may not use this gateway, which is at "
            f"{address.scheme}://{hosts[0]}; DOCK_GATEWAY_ALLOWED_ORIGINS can allow them, and a proxy that speaks TLS "
            "has to send X-Forwarded-Proto, from an address in DOCK_GATEWAY_TRUSTED_PROXIES"
        )


class Address(NamedTuple):
    """An origin, in the sense of browsers."""

    scheme: str
    name: str
    port: int


def _read_origin(origin: str) -> Address | None:
    scheme, separator, host = origin.partition("://")
    return _read_address(scheme, host) if separator else None


def _read_address(scheme: str, host: str) -> Address | None:
    """Return the address that `Host` names; None if it is not a host name or IP address with an optional port."""
    match = HOST.fullmatch(host.lower())
    if match is None or scheme not in PORTS:
        return None
    port = int(match["port"] or PORTS[scheme])
    return Address(scheme, match["name"].strip("[]"), port) if 0 < port < 65536 else None


def _is_address(name: str) -> bool:
    """Whether the name is an IP address, which DNS rebinding cannot redirect."""
    try:
        ip_address(name)
    except ValueError:
        return False
    return True
