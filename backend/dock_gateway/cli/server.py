"""The server process: uvicorn with our connections, and streams that end with a reason."""

import asyncio
import gc
import logging
import os
import signal
import socket
import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import TypeVar, cast

import uvicorn
from starlette.types import ASGIApp
from uvicorn.config import STARTUP_FAILURE

from dock_gateway.cli.hangup import Hangup, Reread
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.log_config import configure_logs
from dock_gateway.core.tasks import Tasks
from dock_gateway.http.edge.certificates import Certificates, load_certificates
from dock_gateway.http.edge.connection import GuardedConnection
from dock_gateway.http.edge.forwarded import ForwardedHeaders
from dock_gateway.http.edge.limits import raise_file_limit
from dock_gateway.http.edge.listener import PortListener
from dock_gateway.http.edge.options import edge_options
from dock_gateway.http.edge.security import SecurityHeaders
from dock_gateway.http.edge.tls import open_tls
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.own_ports import OwnPorts
from dock_gateway.http.parts import Parts
from dock_gateway.http.request_id import RequestId
from dock_gateway.settings import Settings, unknown_variables

log = logging.getLogger(__name__)

# Seconds at shutdown for answers in progress, and before that for streams to send their closing message.
GRACE = 1
FAREWELL = 0.5

ConnectionFactory = Callable[..., GuardedConnection]
S = TypeVar("S", bound=Settings)
OpenParts = Callable[[S], AbstractAsyncContextManager[Parts]]
CreateApp = Callable[[S, Parts], ASGIApp]
# Called with the parts and the port, once it is listened on.
OnListening = Callable[[Parts, int], object]
OnRereadWithParts = Callable[[Parts, Settings], object]


class Server(uvicorn.Server):
    """A uvicorn server that logs its address and lets streams send `closing` before it closes their connections."""

    def __init__(
        self,
        config: uvicorn.Config,
        certificates: Certificates | None = None,
        on_listening: OnListening = lambda *_: None,
    ) -> None:
        super().__init__(config)
        self._on_listening = on_listening
        self._ways = FurtherWays()
        self._certificates = certificates
        self._parts: Parts | None = None
        self._own_ports: dict[int, str] = {}
        self._tasks = Tasks("watching the certificate")

    async def serve_app(self, app: ASGIApp, parts: Parts, settings: Settings) -> None:
        """Serve until a signal arrives. Return at once if one has arrived before."""
        if self.should_exit:
            return
        self._parts = parts
        self._ways = parts[FurtherWays]
        self._app = app = RequestId(SecurityHeaders(app, tls=settings.tls))
        self._own_ports = settings.own_ports
        self.config.app = ForwardedHeaders(OwnPorts(app, self._own_ports), settings.trusted_proxies)
        gc.freeze()  # loaded modules stay: collecting them would block everything for 100 ms now and then
        await self.serve()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, and log the addresses."""
        listeners = [("http", self._bind(self.config.port))]
        listeners += [("ws", self._bind(port)) for port in self._own_ports]
        await super().startup(sockets=[])
        secure = "" if self._certificates is None else "s"
        if self._certificates is not None:
            self._tasks.spawn(self._certificates.watch())
        for scheme, listener in listeners:
            self.servers.append(cast("asyncio.Server", listener))
            listener.start(self._open)
            for host, port, *_ in (bound.getsockname() for bound in listener.sockets):
                log.info("listening on %s%s://%s:%d", scheme, secure, f"[{host}]" if ":" in host else host, port)
        if self._parts is not None:
            self._on_listening(self._parts, listeners[0][1].sockets[0].getsockname()[1])
        for way in self._ways:
            await way.open(self._app, self.lifespan.state)

    def _bind(self, port: int) -> PortListener:
        try:
            return PortListener(self.config.host, port)
        except OSError as error:
            log.error("cannot listen on %s, port %d: %s", self.config.host, port, error)
            raise SystemExit(STARTUP_FAILURE) from error

    async def _open(self, sock: socket.socket) -> None:
        connection = cast("ConnectionFactory", self.config.http_protocol_class)(
            config=self.config, server_state=self.server_state, app_state=self.lifespan.state
        )
        if self._certificates is None:
            await asyncio.get_running_loop().connect_accepted_socket(lambda: connection, sock)
        else:
            await open_tls(sock, connection, self._certificates.context)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End every stream with a reason, then shut down."""
        for way in self._ways:
            await way.leave()
        if self._parts is not None:
            fanout = self._parts[Fanout]
            fanout.close()
            deadline = time.monotonic() + FAREWELL
            while len(fanout) and time.monotonic() < deadline:  # noqa: ASYNC110 - the last one does not say
                await asyncio.sleep(0.01)
        for way in self._ways:
            await way.close()
        await super().shutdown(sockets)
        await self._tasks.close()


def run(
    settings: S,
    open_parts: OpenParts[S],
    create_app: CreateApp[S],
    on_listening: OnListening = lambda *_: None,
    *,
    reread: Reread,
    on_reread: OnRereadWithParts = lambda *_: None,
) -> bool:
    """Serve until a signal arrives. Return False if the server could not be started.

    Args:
        settings: The settings.
        open_parts: Opens the parts, until the server has shut down.
        create_app: Makes the application of them.
        on_listening: Called with the parts and the port, once it is listened on.
        reread: Reads the settings again, after SIGHUP.
        on_reread: Called with the parts and what was read again.

    Raises:
        CertificateError: A certificate or key cannot be used.
    """
    certificates = load_certificates(settings)
    configure_logs(settings)
    for sentence in unknown_variables(os.environ, type(settings).model_fields):
        log.warning(sentence)
    raise_file_limit()
    _say_who_may_use(settings)
    config = uvicorn.Config(
        "",
        host=settings.host,
        port=settings.port,
        timeout_graceful_shutdown=GRACE,
        log_config=None,
        access_log=settings.log_level == "debug",
        server_header=False,
        **edge_options(settings),
    )
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        server = Server(config, certificates, on_listening)
        return runner.run(_serve(server, settings, open_parts, create_app, reread, on_reread))


def _say_who_may_use(settings: Settings) -> None:
    """Log that no login is needed, and what would change that."""
    match settings.open_to:
        case "machine":
            log.info(
                "open: every program on this machine may move the robots, without a login; --authentication asks "
                "for one (docs/access.md)"
            )
        case "network":
            log.warning(
                "OPEN TO THE NETWORK: anyone who reaches %s may move the robots, without a login; "
                "--authentication asks for one (docs/access.md)",
                settings.published_on or settings.host,
            )


async def _serve(
    server: Server,
    settings: S,
    open_parts: OpenParts[S],
    create_app: CreateApp[S],
    reread: Reread,
    on_reread: OnRereadWithParts,
) -> bool:
    def take(fresh: Settings) -> None:
        if opened:
            on_reread(opened[0], fresh)

    opened: list[Parts] = []
    with server.capture_signals():  # from now on, and until everything is closed
        Hangup(settings, reread, take, lambda: server.handle_exit(signal.SIGHUP, None)).listen()
        async with open_parts(settings) as parts:
            opened.append(parts)
            await server.serve_app(create_app(settings, parts), parts, settings)
    return server.started
