"""The server process: uvicorn with our farewell and our short way to WebSockets."""

import asyncio
import ctypes
import logging
import os
import socket
import threading
from contextlib import suppress

import uvicorn

from dock_gateway.api.frames import FramesProtocol
from dock_gateway.app import create_app
from dock_gateway.gateway import Gateway
from dock_gateway.settings import LOOPBACK_HOSTS, Settings

log = logging.getLogger(__name__)

# Answers under way get so many seconds when the process is told to end.
GRACE = 1
# Once everything has been closed, the process is gone after so many seconds at the latest.
LEAVE_AFTER = 1.0
M_ARENA_MAX = -8  # <malloc.h>


class Server(uvicorn.Server):
    """uvicorn, which says where it listens and lets streams say goodbye before it closes their connections."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, and log the address."""
        await super().startup(sockets)
        for listener in (listener for server in self.servers for listener in server.sockets):
            host, port = listener.getsockname()[:2]
            log.info("listening on http://%s:%d", f"[{host}]" if ":" in host else host, port)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End every stream with a reason, then everything else."""
        gateway: Gateway | None = getattr(self.config.app.state, "gateway", None)  # type: ignore[union-attr]
        if gateway is not None:
            gateway.say_goodbye()
            await asyncio.sleep(0.1)
        await super().shutdown(sockets)
        # All is said and written. What does not end now, such as a driver that waits for a locked database, never will.
        leave = threading.Timer(LEAVE_AFTER, os._exit, (0,))
        leave.daemon = True
        leave.start()


def _log_config(level: str) -> None:
    logging.basicConfig(level=level.upper(), format="[%(levelname)s] [%(asctime)s] [%(name)s]: %(message)s")
    for noisy in ("alembic", "asyncio", "httpcore", "httpx2", "websockets"):
        logging.getLogger(noisy).setLevel(logging.WARNING)
    if level != "debug":
        logging.getLogger("uvicorn").setLevel(logging.WARNING)


def _share_heaps() -> None:
    """Have the threads share two heaps: the C library makes each of some twenty its own otherwise, 12 MB in all."""
    with suppress(OSError, AttributeError):  # another C library than glibc
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 2)


def run(settings: Settings) -> bool:
    """Serve until a signal comes; False where the server could not be started."""
    _log_config(settings.log_level)
    if "MALLOC_ARENA_MAX" not in os.environ:
        _share_heaps()
    if settings.host not in LOOPBACK_HOSTS:
        log.warning(
            "listening on %s: everyone who reaches this machine on the network can move the robot",
            settings.host,
        )
    config = uvicorn.Config(
        create_app(settings),
        host=settings.host,
        port=settings.port,
        ws=FramesProtocol,
        ws_max_size=settings.max_body_bytes,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GRACE,
        log_config=None,
        server_header=False,
    )
    server = Server(config)
    server.run()
    return server.started
