"""A subscription at the NATS broker, renewed on each connection, and what it receives."""

import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from nats import errors
from nats.aio.msg import Msg
from nats.aio.subscription import Subscription as NatsSubscription

from dock_gateway.sites.nats_client import NatsClient

# What may wait for a handler, for each subscription: messages, and bytes.
MAX_MESSAGES, MAX_BYTES = 16_384, 64 * 1024 * 1024
INBOXES = "_INBOX."


@dataclass(frozen=True)
class SiteMessage:
    """A message that has arrived."""

    subject: str
    data: bytes
    _reply_to: str = field(repr=False)
    _publish: Callable[[str, bytes], Awaitable[None]] = field(repr=False)

    async def reply(self, data: bytes) -> None:
        """Answer, if the sender waits for one. Others than inboxes get none: a site must not speak through the hub.

        Raises:
            Unavailable: There is no connection to the broker.
        """
        if self._reply_to.startswith(INBOXES):
            await self._publish(self._reply_to, data)


class BrokerSubscription:
    """Messages of one subject, on each connection until it is closed.

    Args:
        subject: May have wildcards.
        handler: Called with each message, one after the other.
        on_close: Called when it is closed.
    """

    def __init__(
        self, subject: str, handler: Callable[[Msg], Awaitable[None]], on_close: Callable[["BrokerSubscription"], None]
    ) -> None:
        self._subject = subject
        self._handler = handler
        self._on_close = on_close
        self._on: NatsClient | None = None
        self._nats: NatsSubscription | None = None

    def is_on(self, client: NatsClient) -> bool:
        """Return whether that connection has it."""
        return self._on is client

    async def place(self, client: NatsClient) -> None:
        """Subscribe on a connection."""
        self._on = client
        self._nats = await client.subscribe(
            self._subject, cb=self._handler, pending_msgs_limit=MAX_MESSAGES, pending_bytes_limit=MAX_BYTES
        )

    async def close(self) -> None:
        """End the subscription. What waits for its handler is dropped. Idempotent."""
        self._on_close(self)
        nats, self._nats = self._nats, None
        if nats is not None:
            with contextlib.suppress(errors.Error):
                await nats.unsubscribe()
