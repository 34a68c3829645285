"""`/sites/{site}/…`: the site's own API. A request is signed for who makes it, and carried to the site."""

import asyncio
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from http import HTTPStatus
from urllib.parse import parse_qsl, urlencode

from fastapi import APIRouter, Request, WebSocket
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import Message, Receive, Send
from starlette.types import Scope as ConnectionScope
from starlette.websockets import WebSocketDisconnect, WebSocketState

from dock_gateway.access.logins import Logins, login_ended
from dock_gateway.audit.trail import Trail, audited
from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.grant import UNLIMITED, Role
from dock_gateway.core.tasks import cancel
from dock_gateway.http import operation as needs
from dock_gateway.http.operation import operation, operation_of
from dock_gateway.http.parts import parts_of
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.requests import read_body
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.slow_clients import send_in_time
from dock_gateway.settings import Settings
from dock_gateway.sites.names import site_grant, to_hub
from dock_gateway.sites.tunnel.failures import SiteTimeout
from dock_gateway.sites.tunnel.frames import STOP
from dock_gateway.streams.events import CLOSE_CODES
from dock_hub.site_client import DEADLINE, SiteClient, SiteRequest
from dock_hub.sites import Sites
from dock_hub.stop_requests import BODY_WITHIN, STOPS_UNSEEN

router = APIRouter(route_class=ApiRoute, tags=["Sites"])

METHODS = ["GET", "POST", "PUT", "PATCH", "DELETE"]
# The WebSockets that only read. The hub records that any other was opened, as it may take commands, which the site
# records.
READING = frozenset({"ws/feedback", "ws/topics"})
# The code with which a WebSocket is closed whose site was lost.
SITE_LOST = 1014
# The headers of a stop at a site, and the bytes of a value.
STOP_HEADERS, LONGEST_VALUE = frozenset({b"content-type", b"prefer", b"idempotency-key"}), 1000
Pairs = list[tuple[bytes, bytes]]


@router.api_route("/sites/{site}/{path:path}", methods=METHODS, name="forward_request", include_in_schema=False)
@operation(Role.VIEWER, needs.Scope.ANY, reads_body=True, any_query=True)
async def forward_request(site: str, path: str, request: Request) -> Response:
    """Carry a request to a site, and its answer back. The site decides what its user may do there.

    A stop is for everyone: of every site, also one that is beyond the user's limits, without a place, and at once.
    """
    parts, principal = parts_of(request), principal_of(request)
    robots = [to_hub(site, f"/{name.strip('/')}") for name in request.query_params.getlist("robot")]
    audited(request, subject=f"{request.method} /sites/{site}/{path}"[:200], robot=",".join(robots)[:200] or None)
    stops = (request.method, f"/{path}") == STOP  # however it was written: see `http.edge.targets`
    client = parts[Sites].client(site, UNLIMITED if stops else principal.grant)
    body = await _read_stop(request) if stops else await read_body(request)
    parts[Logins].require_valid(principal)  # the body may have taken its time
    return Forwarded(client, _asked(client, f"/{path}", request, body, stops=stops), stops=stops)


@router.websocket("/sites/{site}/{path:path}", name="forward_websocket")
@operation(Role.VIEWER, needs.Scope.ANY)
async def forward_websocket(site: str, path: str, websocket: WebSocket) -> None:
    """Carry a WebSocket to a site. It ends with the login at the hub."""
    parts, principal = parts_of(websocket), principal_of(websocket)
    client = parts[Sites].client(site, principal.grant)
    asked = _asked(client, f"/{path}", websocket)
    if path not in READING:
        trail = Trail(websocket.scope, "forward_websocket", {}, operation_of(forward_websocket))
        trail.fields |= {"robot": None, "subject": f"/sites/{site}/{path}"[:200]}
        await trail.record(HTTPStatus.SWITCHING_PROTOCOLS)
    with _places(websocket, site):
        await Stream(websocket).run(client, asked)


class Forwarded(Response):
    """The answer of a site, as it comes.

    Args:
        client: The site.
        asked: What it is asked.
        stops: Whether that is a stop, which is not counted.
    """

    def __init__(self, client: SiteClient, asked: SiteRequest, *, stops: bool) -> None:
        super().__init__()
        self._client = client
        self._asked = asked
        self._stops = stops

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Send the request, and then what comes."""
        connection = HTTPConnection(scope)
        timeout = parts_of(connection)[Settings].subscriber_timeout
        asked, site = self._asked, self._client.address.site
        waiting: list[Message] = [{"type": "http.request", "body": asked.body, "more_body": False}]

        async def receive_all() -> Message:
            return waiting.pop() if waiting else await receive()

        async def send_own(message: Message) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*_answered(message.get("headers", ()), f"/sites/{site}")]}
            await send_in_time(send, message, timeout)

        carrying = asyncio.ensure_future(self._client.forward(asked, scope, receive_all, send_own))
        try:
            with (
                nullcontext() if self._stops else _places(connection, site),
                parts_of(connection)[Logins].watch(principal_of(connection), carrying.cancel),
            ):
                await asyncio.wait((carrying,))
        finally:
            await cancel(carrying)
        try:
            if carrying.cancelled():
                raise login_ended()
            carrying.result()
        except SiteTimeout as error:
            error.extra["idempotency_key"] = Headers(raw=asked.headers).get("idempotency-key")
            raise


class Stream:
    """A WebSocket that is carried to a site.

    Args:
        websocket: The connection of the client.
    """

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        self._timeout = parts_of(websocket)[Settings].subscriber_timeout

    async def run(self, client: SiteClient, asked: SiteRequest) -> None:
        """Carry messages both ways until either side ends it, or the login ends."""
        websocket, ended = self._websocket, asyncio.Event()
        carrying = asyncio.ensure_future(client.forward(asked, websocket.scope, websocket.receive, self._send))
        ending = asyncio.ensure_future(ended.wait())
        try:
            with parts_of(websocket)[Logins].watch(principal_of(websocket), ended.set):
                await asyncio.wait((carrying, ending), return_when=asyncio.FIRST_COMPLETED)
        finally:
            await cancel(ending, carrying)
        if websocket.application_state is WebSocketState.CONNECTING:
            if carrying.cancelled():
                raise login_ended()
            carrying.result()  # what kept it from being opened is the answer
        elif WebSocketState.CONNECTED is websocket.application_state is websocket.client_state:
            with suppress(WebSocketDisconnect):
                if carrying.cancelled():
                    await websocket.close(CLOSE_CODES["invalid_token"], "invalid_token")
                elif carrying.exception() is not None:
                    await websocket.close(SITE_LOST, "site_unreachable")

    async def _send(self, message: Message) -> None:
        await send_in_time(self._websocket.send, message, self._timeout)


@contextmanager
def _places(connection: HTTPConnection, site: str) -> Iterator[None]:
    """Take a place among the requests to all sites, and among those to one, while the block runs."""
    quotas, principal = parts_of(connection)[Quotas], principal_of(connection)
    with quotas.slot(principal, "requests"), quotas.slot(principal, "requests of one", per=site):
        yield


async def _read_stop(request: Request) -> bytes:
    """Return the body of a stop, which is carried on without it if it does not come at once."""
    try:
        return await read_body(request, BODY_WITHIN)
    except MalformedRequest:
        return b""


def _asked(
    client: SiteClient, path: str, connection: HTTPConnection, body: bytes = b"", *, stops: bool = False
) -> SiteRequest:
    """Return the request of a client, as a site gets it."""
    principal = principal_of(connection)
    grant = site_grant(principal.grant, client.address.site) or STOPS_UNSEEN  # else, only a stop gets here
    query = connection.scope["query_string"]
    if connection.scope["type"] == "websocket":
        query = _without_ticket(query)
    return SiteRequest(
        connection.scope.get("method", "GET"),
        path,
        query.decode("latin-1"),
        body,
        principal.name,
        grant,
        _headers(connection, stops=stops),
        DEADLINE,
    )


def _headers(connection: HTTPConnection, *, stops: bool = False) -> Pairs:
    """Return the headers of a request. What may be sent twice gets a key, so that it is done once.

    A stop has only those that it needs: a site refuses requests with too many, or with odd ones.
    """
    headers: Pairs = list(connection.scope["headers"])
    if stops:
        headers = [(name, value) for name, value in headers if name in STOP_HEADERS and len(value) < LONGEST_VALUE]
    if connection.scope.get("method") == "POST" and "idempotency-key" not in connection.headers:
        headers.append((b"idempotency-key", uuid.uuid4().hex.encode()))
    return headers


def _answered(headers: Iterable[tuple[bytes, bytes]], prefix: str) -> Iterable[tuple[bytes, bytes]]:
    """Return the headers of an answer for who is at the hub: a path is below that of the site."""
    for name, value in headers:
        yield name, prefix.encode() + value if name.lower() == b"location" and value[:1] == b"/" else value


def _without_ticket(query: bytes) -> bytes:
    """Return a query without the ticket, which is one of the hub's login."""
    pairs = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    return urlencode([pair for pair in pairs if pair[0] != TICKET]).encode()
