"""The server process: uvicorn with our farewell and our short way to WebSockets.

The gateway joins the ROS graph before the web is loaded: ROS may need as long to find the action servers.
"""

import asyncio
import ctypes
import gc
import logging
import os
import socket
import sys
import threading
from contextlib import suppress

import uvicorn

from dock_gateway.gateway import Gateway, open_gateway
from dock_gateway.settings import LOOPBACK_HOSTS, Settings
from dock_gateway.tasks import cancel

log = logging.getLogger(__name__)

# Answers under way get so many seconds when the process is told to end.
GRACE = 1
# Once everything has been closed, the process is gone after so many seconds at the latest.
LEAVE_AFTER = 1.0
M_ARENA_MAX = -8  # <malloc.h>


class Server(uvicorn.Server):
    """uvicorn, which says where it listens and lets streams say goodbye before it closes their connections."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self._gateway: Gateway | None = None

    async def run_beside(self, gateway: Gateway, settings: Settings) -> None:
        """Load the web, and serve the gateway until a signal comes."""
        if self.should_exit:
            return
        # FastAPI would load it, for 60 ms and 3 MB, to ask whether a model is one of its kind; none is.
        sys.modules.setdefault("pydantic.v1", None)  # type: ignore[arg-type]
        from dock_gateway.api.frames import FramesProtocol  # noqa: PLC0415
        from dock_gateway.app import create_app  # noqa: PLC0415

        self._gateway = gateway
        settling = asyncio.create_task(_settle(gateway))
        self.config.app = create_app(settings, gateway)
        self.config.ws = FramesProtocol
        try:
            await self.serve()
        finally:
            await cancel(settling)

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
            await asyncio.sleep(0.1)
        await super().shutdown(sockets)


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


async def _settle(gateway: Gateway) -> None:
    """Once all is loaded: that stays, and what its loading took is given back, 8 MB."""
    await gateway.history.opened()
    gc.freeze()
    gc.enable()
    with suppress(OSError, AttributeError):
        await asyncio.to_thread(ctypes.CDLL(None).malloc_trim, 0)


def run(settings: Settings) -> bool:
    """Serve until a signal comes; False where the server could not be started."""
    gc.disable()  # what is loaded stays: to look through it again and again takes a tenth of the start; see _settle
    _log_config(settings.log_level)
    if "MALLOC_ARENA_MAX" not in os.environ:
        _share_heaps()
    if settings.host not in LOOPBACK_HOSTS:
        log.warning(
            "listening on %s: everyone who reaches this machine on the network can move the robot",
            settings.host,
        )
    config = uvicorn.Config(
        "",
        host=settings.host,
        port=settings.port,
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
        async with open_gateway(settings) as gateway:
            await server.run_beside(gateway, settings)
        # All is said and written. What does not end now, such as a driver that waits for a locked database, never will.
        leave = threading.Timer(LEAVE_AFTER, os._exit, (0,))
        leave.daemon = True
        leave.start()
    return server.started
