"""The NATS broker as sites and hubs use it: what cannot be sent now is refused, never sent later."""

import asyncio
import contextlib
import itertools
import logging
import random
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from nats import errors
from nats.aio.msg import Msg

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.listeners import Listeners
from dock_gateway.sites.nats_client import ConnectFailed, NatsClient
from dock_gateway.sites.servers import read_server
from dock_gateway.sites.subjects import new_id
from dock_gateway.sites.subscription import BrokerSubscription, SiteMessage

log = logging.getLogger(__name__)

# Bytes that may wait for a slow connection before who sends more has to wait.
MAX_WAITING = 256 * 1024
# A message's size before a server has said its limit.
DEFAULT_MAX_PAYLOAD = 1024 * 1024
# Seconds for which messages of a subject are handled before others have their turn.
WITHOUT_BREAK = 0.002
NO_RESPONDERS = "503"


@dataclass(frozen=True)
class BrokerOptions:
    """The broker's addresses, and who connects.

    Attributes:
        urls: NATS servers: `tls://[user:password@]host[:port]` or `nats://…`. Any one of them will do.
        credentials: A `.creds` file.
        ca: Certificates that servers may have been issued by; None for those that the machine trusts.
        name: Shown in the broker's monitoring.
        inbox: The prefix of the replies, such as `_INBOX.hub`.
        waits: Seconds between attempts to connect: the first, and at most.
        check: Seconds between checks of the connection, and for the answer to one.
    """

    urls: tuple[str, ...]
    credentials: Path | None
    ca: Path | None
    name: str
    inbox: str
    waits: tuple[float, float] = (0.1, 2.0)
    check: tuple[float, float] = (5.0, 8.0)


class NoResponder(Unavailable):
    """No subscriber can answer a request."""

    code = "no_responder"


class Broker:
    """The connection to the broker, which is made again whenever it is lost.

    Attributes:
        on_connect: Called when a connection has come about, with all subscriptions in place.
        on_loss: Called when it is lost.
        refused: Number of messages that were dropped, by reason.
    """

    def __init__(self, options: BrokerOptions) -> None:
        self.on_connect = Listeners[[]]("the NATS server is connected")
        self.on_loss = Listeners[[]]("the NATS server is lost")
        self.refused: Counter[str] = Counter()
        self._options = options
        self._client: NatsClient | None = None
        self._subscriptions: list[BrokerSubscription] = []
        self._inbox = f"{options.inbox}.{new_id()}"
        self._replies: dict[str, asyncio.Future[bytes]] = {}
        self._add(f"{self._inbox}.*", self._on_reply)
        self._complaint = ""

    @property
    def connected(self) -> bool:
        """Whether messages can be sent now."""
        return self._client is not None and self._client.usable

    @property
    def max_payload(self) -> int:
        """Bytes of the largest message that the server takes."""
        return DEFAULT_MAX_PAYLOAD if self._client is None else self._client.max_payload

    def refuse(self, reason: str, subject: str, detail: str) -> None:
        """Count and log a message that was dropped.

        Args:
            reason: A stable name, for the counters.
            subject: Where it came from.
            detail: A sentence.
        """
        self.refused[reason] += 1
        log.warning("dropped a message on %s: %s", subject, detail)

    async def publish(self, subject: str, data: bytes, *, reply_to: str = "") -> None:
        """Send a message. Waits while a slow connection has too much to send.

        Raises:
            Unavailable: There is no connection, or the message is too large for the server.
        """
        client = self._usable()
        while client.pending_data_size > MAX_WAITING:
            await asyncio.sleep(0.005)
            if not client.usable:
                raise _unavailable()
        if len(data) > client.max_payload:
            raise Unavailable(
                f"a message of {len(data)} bytes; the broker takes at most {client.max_payload}",
                code="message_too_large",
            )
        try:
            await client.publish(subject, data, reply=reply_to)
        except errors.Error:
            raise _unavailable() from None

    async def request(self, subject: str, data: bytes, timeout: float) -> bytes:
        """Send a message and return the answer.

        Raises:
            Unavailable: There is no connection; nothing was sent.
            NoResponder: The subject has no subscriber.
            TimeoutError: No answer in time, or the connection was lost meanwhile: whether the message has arrived is
                not known.
        """
        token = new_id()
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._replies[token] = answer
        try:
            async with asyncio.timeout(timeout):
                await self.publish(subject, data, reply_to=f"{self._inbox}.{token}")
                return await answer
        finally:
            del self._replies[token]
            if not answer.cancel() and not answer.cancelled():
                answer.exception()  # it is known: the message was not sent

    async def subscribe(self, subject: str, handler: Callable[[SiteMessage], Awaitable[None]]) -> BrokerSubscription:
        """Hand messages of a subject to a handler, one after the other, until the subscription is closed.

        The handler must not wait for anything but `reply`: it holds up all that follow. However many come, other work
        goes on in between.
        """
        breaks = 0.0

        async def deliver(message: Msg) -> None:
            nonlocal breaks
            if time.monotonic() - breaks > WITHOUT_BREAK:
                await asyncio.sleep(0)  # nats-py has none while messages wait
                breaks = time.monotonic()
            try:
                await handler(SiteMessage(message.subject, message.data, message.reply, self.publish))
            except Unavailable as error:
                log.info("while handling a message on %s: %s", message.subject, error.detail)
            except Exception:
                log.exception("while handling a message on %s", message.subject)

        subscription = self._add(subject, deliver)
        if self.connected:
            await subscription.place(self._usable())
        return subscription

    def _forget(self, subscription: BrokerSubscription) -> None:
        if subscription in self._subscriptions:
            self._subscriptions.remove(subscription)

    def _add(self, subject: str, handler: Callable[[Msg], Awaitable[None]]) -> BrokerSubscription:
        subscription = BrokerSubscription(subject, handler, self._forget)
        self._subscriptions.append(subscription)
        return subscription

    def _usable(self) -> NatsClient:
        if self._client is None or not self._client.usable:
            raise _unavailable()
        return self._client

    async def _on_reply(self, message: Msg) -> None:
        answer = self._replies.get(message.subject.rpartition(".")[2])
        if answer is None or answer.done():
            return  # too late
        if not message.data and (message.headers or {}).get("Status") == NO_RESPONDERS:
            answer.set_exception(NoResponder("the subject has no subscriber"))
        else:
            answer.set_result(message.data)

    # The connection.

    async def run(self) -> None:
        """Connect, for ever."""
        shortest, longest = self._options.waits
        servers = [read_server(url) for url in self._options.urls]
        random.shuffle(servers)
        wait = shortest
        for server in itertools.cycle(servers):
            client = NatsClient(server)
            try:
                await self._connect(client)
                wait = shortest
                await self._watch(client)
            except ConnectFailed as error:
                self._complain(f"cannot connect to the NATS server {server}: {error}")
            finally:
                await self._leave(client)
            await asyncio.sleep(wait * random.uniform(0.5, 1))  # noqa: S311 - not all at once
            wait = min(longest, wait * 2)

    async def _connect(self, client: NatsClient) -> None:
        options = self._options
        await client.start(name=options.name, ca=options.ca, credentials=options.credentials, on_error=self._on_error)
        try:
            while missing := [each for each in self._subscriptions if not each.is_on(client)]:
                for each in missing:
                    await each.place(client)
                # Seconds. The server has these subscriptions then; others may have come meanwhile.
                await client.rtt(options.check[1])  # type: ignore[arg-type]
        except errors.Error as error:
            raise ConnectFailed(client.reason or str(error)) from None
        self._client = client
        self._complaint = ""
        log.info("connected to the NATS server %s", client.server)
        self.on_connect()

    async def _watch(self, client: NatsClient) -> None:
        interval, patience = self._options.check
        while not client.lost.is_set():
            try:
                async with asyncio.timeout(interval):
                    await client.lost.wait()
            except TimeoutError:
                try:
                    await client.rtt(patience)  # type: ignore[arg-type]  # seconds
                except errors.Error:
                    client.reason = client.reason or f"no answer for {patience:g} s"
                    break
        self._complain(f"lost the NATS server {client.server}: {client.reason or 'the connection was closed'}")

    async def _leave(self, client: NatsClient) -> None:
        if self._client is client:
            self._client = None
            for answer in self._replies.values():
                if not answer.done():
                    answer.set_exception(TimeoutError("the connection to the broker was lost"))
            self.on_loss()
        await client.abandon()

    async def flush(self, timeout: float) -> None:
        """Wait until the server has everything that was sent, or the time has passed."""
        if self.connected:
            with contextlib.suppress(errors.Error):
                await self._usable().rtt(timeout)  # type: ignore[arg-type]  # seconds

    async def _on_error(self, error: Exception) -> None:
        if isinstance(error, errors.SlowConsumerError):
            self.refuse("slow_consumer", error.subject, "messages arrive faster than they are handled")
        elif "permissions violation" in str(error).lower():
            self.refused["not_permitted"] += 1
            log.warning("the NATS server does not permit it: %s", error)

    def _complain(self, complaint: str) -> None:
        if complaint != self._complaint:
            self._complaint = complaint
            log.warning("%s", complaint)


def _unavailable() -> Unavailable:
    return Unavailable("there is no connection to a NATS server", code="broker_unavailable")


@asynccontextmanager
async def open_broker(options: BrokerOptions) -> AsyncIterator[Broker]:
    """Connect in the background, for ever. Does not wait for the first connection.

    Raises:
        ValueError: A URL is not one of a NATS server.
    """
    for url in options.urls:
        read_server(url)
    broker = Broker(options)
    running = asyncio.create_task(broker.run())
    try:
        yield broker
    finally:
        await broker.flush(1.0)
        while not running.done():  # nats-py, and `wait_for` of Python 3.11, may swallow a cancellation
            running.cancel()
            await asyncio.wait({running}, timeout=0.1)
