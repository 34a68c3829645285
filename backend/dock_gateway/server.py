"""The server process: uvicorn with our farewell and our frame writer for WebSockets."""

import asyncio
import logging
import signal
import socket
import time

import uvicorn

from dock_gateway.api.frames import FramesProtocol
from dock_gateway.app import create_app
from dock_gateway.gateway import Gateway, open_gateway
from dock_gateway.log_limit import LogLimit
from dock_gateway.settings import LOOPBACK_HOSTS, Settings

log = logging.getLogger(__name__)

# Seconds that answers under way get when the process is told to end, and that streams get before to say goodbye.
GRACE = 1
FAREWELL = 0.5


class Server(uvicorn.Server):
    """uvicorn, which says where it listens and lets streams say goodbye before it closes their connections."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self._gateway: Gateway | None = None

    async def serve_gateway(self, gateway: Gateway, settings: Settings) -> None:
        """Serve until a signal comes; not at all where it came before."""
        if self.should_exit:
            return
        self._gateway = gateway
        self.config.app = create_app(settings, gateway)
        await self.serve()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, and log the address."""
        await super().startup(sockets)
        for listener in (listener for server in self.servers for listener in server.sockets):
            host, port = listener.getsockname()[:2]
            log.info("listening on http://%s:%d", f"[{host}]" if ":" in host else host, port)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End every stream with a reason, then everything else."""
        if self._gateway is not None:
            self._gateway.say_goodbye()
            deadline = time.monotonic() + FAREWELL
            while len(self._gateway.hub) and time.monotonic() < deadline:  # noqa: ASYNC110 - the last one does not say
                await asyncio.sleep(0.01)
        await super().shutdown(sockets)


def _log_config(level: str) -> None:
    logging.basicConfig(level=level.upper(), format="[%(levelname)s] [%(asctime)s] [%(name)s]: %(message)s")
    if level != "debug":
        for handler in logging.getLogger().handlers:
            handler.addFilter(LogLimit())
    for noisy in ("alembic", "asyncio", "httpcore", "httpx2", "websockets"):
        logging.getLogger(noisy).setLevel(logging.WARNING)
    if level != "debug":
        logging.getLogger("uvicorn").setLevel(logging.WARNING)


def run(settings: Settings) -> bool:
    """Serve until a signal comes; False where the server could not be started."""
    _log_config(settings.log_level)
    if settings.host not in LOOPBACK_HOSTS:
        log.warning(
            "listening on %s: everyone who reaches this machine on the network can move the robot",
            settings.host,
        )
    config = uvicorn.Config(
        "",
        host=settings.host,
        port=settings.port,
        ws=FramesProtocol,
        ws_max_size=settings.max_body_bytes,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GRACE,
        log_config=None,
        server_header=False,
    )
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        return runner.run(_serve(Server(config), settings))


async def _serve(server: Server, settings: Settings) -> bool:
    with server.capture_signals():  # from now on, and until everything is closed
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # `nohup` has it ignored
            signal.signal(signal.SIGHUP, server.handle_exit)  # the end of the terminal, which uvicorn leaves out
        async with open_gateway(settings) as gateway:
            await server.serve_gateway(gateway, settings)
    return server.started
