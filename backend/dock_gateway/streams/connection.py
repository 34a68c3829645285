"""A WebSocket on which several tasks send messages. A client that does not read is cut off."""

import asyncio
from contextlib import suppress

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.http.slow_clients import send_in_time
from dock_gateway.streams.events import CLOSE_CODES


class ClientConnection:
    """Sends messages to one client, one after the other.

    Args:
        websocket: The connection.
        timeout: Seconds that the client may go without reading.
    """

    def __init__(self, websocket: WebSocket, timeout: float) -> None:
        self._websocket = websocket
        self._timeout = timeout
        self._sending = asyncio.Lock()
        self._closed = False

    async def send(self, message: Message) -> None:
        """Send a message.

        Raises:
            TimeoutError: The client did not read in time. It is cut off.
            WebSocketDisconnect: The connection is closed.
        """
        async with self._sending:
            try:
                await send_in_time(self._websocket.send, message, self._timeout)
            except TimeoutError:
                await self.close("too_slow")
                raise
            except RuntimeError:  # another message was not read in time: the connection is closed already
                raise WebSocketDisconnect(CLOSE_CODES["too_slow"]) from None

    async def close(self, reason: str) -> None:
        """Close the connection, unless it is closed already."""
        if self._closed:
            return
        self._closed = True
        with suppress(WebSocketDisconnect, RuntimeError):
            await self._websocket.close(CLOSE_CODES[reason], reason)
