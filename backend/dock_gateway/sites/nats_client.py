"""One connection to a NATS server, with nats-py. It ends once, and takes with it whatever was not sent."""

import asyncio
import contextlib
import logging
import ssl
from pathlib import Path
from typing import Any

from nats import errors
from nats.aio.client import PING_PROTO, Client

from dock_gateway.sites.credentials import NatsCredentials, read_credentials
from dock_gateway.sites.servers import ServerAddress

# Seconds for each step of a connection: TCP, TLS, the server's greeting.
CONNECT_TIMEOUT = 5.0
# Above everything that `Broker` lets wait: nats-py never makes a publisher wait, as it could not be cancelled.
UNLIMITED = 1 << 40


class ConnectFailed(Exception):
    """No connection came about. The text is one sentence without secrets."""


class NatsClient(Client):
    """A connection that never reconnects: nats-py would then send what waits, which are commands of before.

    Attributes:
        lost: Set as soon as the connection is over.
        reason: Why, if that is known.
    """

    def __init__(self, server: ServerAddress) -> None:
        super().__init__()
        self.server = server
        self.lost = asyncio.Event()
        self.reason = ""
        self._credentials: NatsCredentials | None = None

    @property
    def usable(self) -> bool:
        """Whether a message can be sent now."""
        return self.is_connected and not self.lost.is_set()

    async def start(self, *, name: str, ca: Path | None, credentials: Path | None, on_error: Any) -> None:
        """Connect.

        Raises:
            ConnectFailed: There is no server, it refuses the login, or the certificate is not valid.
        """

        async def failed(error: Exception) -> None:
            self.reason = str(error) or type(error).__name__
            await on_error(error)

        user, password = self.server.user, self.server.password
        try:
            self._credentials = None if credentials is None else read_credentials(credentials)
            await self.connect(
                [str(self.server)],
                name=name,
                error_cb=failed,
                allow_reconnect=False,
                max_reconnect_attempts=1,
                reconnect_time_wait=0,
                connect_timeout=CONNECT_TIMEOUT,  # type: ignore[arg-type]  # seconds
                pending_size=UNLIMITED,
                tls=ssl.create_default_context(cafile=ca),
                user_credentials=None if credentials is None else str(credentials),
                user=None if password is None else user,
                password=password,
                token=user if password is None else None,
            )
        except (OSError, errors.Error, ValueError) as error:
            raise ConnectFailed(self.reason or str(error) or type(error).__name__) from None

    async def abandon(self) -> None:
        """Close the connection at once, with everything that was not sent."""
        self.lost.set()
        self._forget_pending()
        writer = getattr(self._transport, "_io_writer", None)
        if writer is not None:
            writer.transport.abort()
            with contextlib.suppress(errors.Error, OSError, TimeoutError):
                async with asyncio.timeout(1):
                    await self.close()

    def _forget_pending(self) -> None:
        self._pending = []
        self._pending_data_size = 0

    async def _close(self, status: int, do_cbs: bool = True) -> None:
        # All ends of a connection come by here. nats-py would first wait until a server that is stuck reads the rest.
        self.lost.set()
        self._forget_pending()
        await super()._close(status, do_cbs)

    async def _send_ping(self, future: "asyncio.Future[Any] | None" = None) -> None:
        # That of nats-py overtakes what waits to be sent: its answer would not say that the server has that.
        self._pongs.append(asyncio.Future() if future is None else future)
        await self._send_command(PING_PROTO)
        await self._flush_pending()

    def _setup_nkeys_jwt_connect(self) -> None:
        # nats-py would sign with two more packages, and asks callbacks only where it has a file, too.
        if self._credentials is not None:
            self._user_jwt_cb = self._credentials.jwt.encode
            self._signature_cb = self._credentials.sign

    def _connect_command(self) -> bytes:
        # nats-py goes on in the clear where a server, or who claims to be it, offers no TLS.
        if self.server.tls and not self._server_info.get("tls_required"):
            raise errors.Error("the server offers no TLS, which tls:// asks for")
        return super()._connect_command()


def one_line(record: logging.LogRecord) -> bool:
    """Make one line of a record with a traceback: what others send is no error of the program."""
    if record.exc_info:
        record.msg, record.args = f"{record.getMessage()}: {record.exc_info[1]!r}", ()
        record.exc_info = None
    return True


logging.getLogger("nats.aio.client").addFilter(one_line)
# The end of a connection with TLS: nats-py makes its streams by hand.
logging.getLogger("asyncio").addFilter(lambda record: "eof_received() has no effect" not in record.getMessage())
