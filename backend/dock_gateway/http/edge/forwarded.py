"""The client's address and scheme behind a reverse proxy, which trusted proxies alone may name."""

import logging
from collections.abc import Iterable, Sequence
from ipaddress import IPv4Address, IPv6Address, ip_address, ip_network

from starlette.types import ASGIApp, Receive, Send
from starlette.types import Scope as ConnectionScope

log = logging.getLogger(__name__)

Address = IPv4Address | IPv6Address

FOR, PROTO = b"x-forwarded-for", b"x-forwarded-proto"
# Headers in which proxies name the client. The last two are never read.
NAMING = frozenset({FOR, PROTO, b"forwarded", b"x-real-ip"})
# The scheme of a request and that of a WebSocket, by the value of `X-Forwarded-Proto`.
SCHEMES = dict.fromkeys(("http", "ws"), ("http", "ws")) | dict.fromkeys(("https", "wss"), ("https", "wss"))
# Maximum number of proxies in a row that are followed.
MAX_HOPS = 32
# Maximum number of addresses whose headers are reported as ignored.
MAX_REPORTED = 20


class ForwardedHeaders:
    """ASGI middleware that believes `X-Forwarded-For` and `X-Forwarded-Proto` only of trusted proxies.

    Args:
        app: The application.
        trusted: IP addresses and networks of proxies.
    """

    def __init__(self, app: ASGIApp, trusted: Iterable[str]) -> None:
        self._app = app
        self._networks = [ip_network(each) for each in trusted]
        self._reported: set[str] = set()

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on, with the address and the scheme of its client."""
        if scope["type"] in ("http", "websocket") and scope.get("client"):
            self._apply(scope)
        await self._app(scope, receive, send)

    def _apply(self, scope: ConnectionScope) -> None:
        named = {name for name, _ in scope["headers"]} & NAMING
        if not named:
            return
        peer = scope["client"][0]
        if not self._trusts(read_address(peer)):
            self._report(peer, named)
            return
        proto = _values(scope, PROTO)
        if proto and (scheme := proto[-1].lower()) in SCHEMES:
            scope["scheme"] = SCHEMES[scheme][scope["type"] == "websocket"]
        client = self._client(_values(scope, FOR))
        if client is not None:
            scope["client"] = (str(client), 0)

    def _client(self, hops: Sequence[str]) -> Address | None:
        """Return the last address that no trusted proxy has; None if there is none that can be relied on.

        Each proxy appends the address of its own client. What stands before an address that is not trusted, or before
        something that is no address, may be made up.
        """
        client = None
        for hop in reversed(hops[-MAX_HOPS:]):
            address = read_address(hop)
            if address is None:
                break
            client = address
            if not self._trusts(address):
                break
        return client

    def _trusts(self, address: Address | None) -> bool:
        return address is not None and any(address in network for network in self._networks)

    def _report(self, peer: str, named: set[bytes]) -> None:
        """Log once for each address that its headers are ignored: a proxy may be meant to be trusted."""
        if peer in self._reported or len(self._reported) >= MAX_REPORTED:
            return
        self._reported.add(peer)
        log.warning(
            "%s from %s is ignored, as DOCK_GATEWAY_TRUSTED_PROXIES does not list that address. If it is a reverse "
            "proxy, list it: until then the audit log names the proxy instead of its clients, failed logins of one "
            "delay all, and behind TLS the dashboard is refused (docs/configuration.md)",
            ", ".join(sorted(name.decode().title() for name in named)),
            peer,
        )


def read_address(text: str) -> Address | None:
    """Return the IP address in a text such as `192.0.2.7`, `192.0.2.7:80`, `[2001:db8::1]:80` or `fe80::1%eth0`.

    None if there is none. An IPv4 address within an IPv6 one is that IPv4 address, and a zone is left out: it has a
    meaning on the proxy's machine alone.
    """
    host = text.strip().strip('"')
    if host.startswith("["):
        host, bracket, port = host[1:].partition("]")
        if not bracket or (port and not (port.startswith(":") and port[1:].isdecimal())):
            return None
    elif host.count(":") == 1:
        host, _, port = host.partition(":")
        if not port.isdecimal():
            return None
    try:
        address = ip_address(host.partition("%")[0])
    except ValueError:
        return None
    if isinstance(address, IPv6Address) and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def _values(scope: ConnectionScope, header: bytes) -> list[str]:
    """Return the values of a header that may be a list, and may be there several times."""
    lines = (value.decode("latin1") for name, value in scope["headers"] if name == header)
    return [part.strip() for line in lines for part in line.split(",") if part.strip()]
