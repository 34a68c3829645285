"""Streamed answers to clients that may be slow, disconnect, or not read at all."""

import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator, Mapping
from contextlib import aclosing

from starlette.requests import ClientDisconnect
from starlette.responses import StreamingResponse
from starlette.types import Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.errors import GatewayError

log = logging.getLogger(__name__)


async def send_in_time(send: Send, message: Message, timeout: float) -> None:
    """Send a message. Cut off a client that does not read for `timeout` seconds.

    Raises:
        TimeoutError: The client did not read in time.
    """
    try:
        async with asyncio.timeout(timeout):
            await send(message)
    except TimeoutError:
        log.info("disconnecting a subscriber that did not read for %g s", timeout)
        raise


class PacedResponse(StreamingResponse):
    """A streamed answer that cuts off a client that does not read for `timeout` seconds.

    If the rest becomes unavailable, the connection is cut, so that the client does not take a part for the whole.

    Args:
        first: The first piece.
        chunks: The other pieces. Closed when the answer ends, for whatever reason.
        timeout: Seconds that the client may go without reading.
        media_type: The media type.
        headers: Additional headers.
    """

    def __init__(
        self,
        first: bytes,
        chunks: AsyncGenerator[bytes],
        timeout: float,
        *,
        media_type: str,
        headers: Mapping[str, str],
    ) -> None:
        super().__init__(
            self._pieces(first, chunks), media_type=media_type, headers={"Cache-Control": "no-store", **headers}
        )
        self._chunks = chunks
        self._timeout = timeout

    @staticmethod
    async def _pieces(first: bytes, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        yield first
        async for chunk in chunks:
            yield chunk

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Send the answer."""
        async with aclosing(self._chunks):
            try:
                await super().__call__(scope, receive, lambda message: send_in_time(send, message, self._timeout))
            except (TimeoutError, ClientDisconnect):
                log.debug("a response was not completed")
            except GatewayError as error:
                log.warning("a response was aborted: %s", error.detail)
