"""The deliveries to webhooks: stored first, then sent by one of the gateways that share the history."""

import logging
import uuid
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from typing import Any

import orjson

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import encode
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.webhooks.delivery import DeliveryEntry, DeliveryState, Document, EventType
from dock_gateway.extensions.webhooks.policy import RETRY_AFTER, after_attempt, due, find_open, open_alerts, surplus
from dock_gateway.extensions.webhooks.sender import Sender, sign
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries

log = logging.getLogger(__name__)

# How long after its time a delivery is taken over from the gateway that stored it, which must have ended.
OVERDUE = timedelta(seconds=30)


class Outbox:
    """Stores deliveries, sends them, and keeps what came of them.

    Args:
        webhooks: The webhooks, by id.
        deliveries: What was and is to be sent, by id.
        retry_after: Seconds from each failed attempt to the next one; after the last, the delivery is given up.
        overdue: See `OVERDUE`.

    Attributes:
        attempts: Number of attempts to send, by the state of the delivery after it.
    """

    def __init__(
        self,
        webhooks: SharedBook[WebhookEntry],
        deliveries: SharedEntries[DeliveryEntry],
        *,
        retry_after: Sequence[float] = RETRY_AFTER,
        overdue: timedelta = OVERDUE,
    ) -> None:
        self._retry_after = retry_after
        self._overdue_after = overdue
        self.attempts: Counter[DeliveryState] = Counter()
        self._webhooks = webhooks
        self._deliveries = deliveries
        self._sender = Sender()
        self._mine: set[str] = set()  # deliveries that this gateway sends
        self._sending: set[str] = set()  # webhooks
        self._tasks = Tasks("sending to webhooks")

    async def read(self) -> Mapping[str, DeliveryEntry]:
        """Return all deliveries by their ids.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self._deliveries.read()

    def sent_to(self, webhook_id: str) -> list[tuple[str, DeliveryEntry]]:
        """Return the deliveries of a webhook with their ids, as they were read last, newest first."""
        own = [(identity, each) for identity, each in self._deliveries.all().items() if each.webhook_id == webhook_id]
        return sorted(own, key=lambda item: (item[1].created_at, item[0]), reverse=True)

    async def open_before(self, moment: datetime) -> list[DeliveryEntry] | None:
        """Return the deliveries of alerts that were raised before a moment and not cleared since.

        None: the history does not answer.
        """
        if not await self._deliveries.sync():
            return None
        return [each for each in open_alerts(self._deliveries.all()).values() if each.created_at < moment]

    async def add(self, event_type: EventType, webhook_id: str, alert_id: str, event: Document) -> None:
        """Store the beginning or the end of an alert, and send it, unless another gateway was first.

        If the history does not answer, it is sent all the same: better twice than never.
        """
        identity = uuid.uuid4().hex
        raised = find_open(self._deliveries.all(), webhook_id, alert_id)
        now = utc_now() if raised is None else max(utc_now(), raised.created_at + timedelta(microseconds=1))
        delivery = _new(webhook_id, event_type, alert_id, now, event)

        def check(stored: Any) -> None:
            if (find_open(stored, webhook_id, alert_id) is None) is (event_type is EventType.CLEARED):
                raise Conflict("another gateway was first")

        try:
            await self._deliveries.store(identity, delivery, check)
        except Conflict:
            await self._deliveries.sync()
            return
        except Unavailable:
            self._deliveries.put(identity, delivery)
        self._mine.add(identity)
        webhook = self._webhooks.get(webhook_id)
        name = webhook_id if webhook is None else webhook.name
        log.info("webhook %r: %s, %s", name, event_type.value, event["text"])
        self._send_mine()

    async def tidy(self) -> None:
        """Read what other gateways have stored, and remove what no longer counts."""
        if not await self._deliveries.sync():
            return
        webhooks, stored = self._webhooks.all(), dict(self._deliveries.all())
        still_open = open_alerts(stored)
        unwanted = set(surplus(stored))
        for identity, delivery in stored.items():
            webhook = webhooks.get(delivery.webhook_id)
            counts = delivery.state is DeliveryState.PENDING or identity in still_open
            if webhook is None or (counts and not webhook.enabled):
                unwanted.add(identity)
        for identity in unwanted:
            self._deliveries.put(identity, None)
        await self._deliveries.save()
        self._mine &= self._deliveries.keys()

    async def send_due(self) -> None:
        """Send the deliveries that are due, also for gateways that have ended."""
        # An overdue delivery was left by a gateway that has ended, unless that gateway has sent it in the meantime.
        if self._overdue() - self._mine and await self._deliveries.sync():
            self._mine |= self._overdue()
        self._send_mine()

    def _send_mine(self) -> None:
        """Send the deliveries that are due here, in background tasks: one for each webhook, one delivery at a time."""
        for webhook_id in {delivery.webhook_id for _, delivery in self._due()} - self._sending:
            self._sending.add(webhook_id)
            self._tasks.spawn(self._send(webhook_id))

    def _overdue(self) -> set[str]:
        return {identity for identity, _ in due(self._deliveries.all(), utc_now() - self._overdue_after)}

    def _due(self) -> list[tuple[str, DeliveryEntry]]:
        return [(identity, each) for identity, each in due(self._deliveries.all(), utc_now()) if identity in self._mine]

    async def _send(self, webhook_id: str) -> None:
        """Send the deliveries that are due for a webhook, one at a time."""
        try:
            while found := [each for each in self._due() if each[1].webhook_id == webhook_id]:
                webhook = self._webhooks.get(webhook_id)
                if webhook is None or not webhook.enabled:
                    return
                await self._attempt(webhook, *found[0])
        finally:
            self._sending.discard(webhook_id)

    async def _attempt(self, webhook: WebhookEntry, identity: str, delivery: DeliveryEntry) -> DeliveryEntry:
        body = encode(delivery.event)
        answer = await self._sender.send(webhook.url, sign(webhook.secret, identity, utc_now(), body), body)
        tried = after_attempt(delivery, answer, utc_now(), self._retry_after)
        self.attempts[tried.state] += 1
        if self._webhooks.get(delivery.webhook_id) is not None:
            self._deliveries.put(identity, tried)
            await self._deliveries.save()
        if tried.error is not None:
            then = "given up" if tried.next_at is None else f"again at {tried.next_at:%H:%M:%S} UTC"
            log.warning("webhook %r: %s was not delivered: %s; %s", webhook.name, identity, tried.error, then)
        return tried

    async def send_test(self, webhook_id: str, webhook: WebhookEntry) -> Document:
        """Send a test now, once; return the delivery."""
        now, identity = utc_now(), uuid.uuid4().hex
        event = {"text": f"This is a test of the webhook {webhook.name!r}.", "data": {}}
        tried = await self._attempt(webhook, identity, _new(webhook_id, EventType.TEST, None, now, event))
        return tried.document(identity)

    async def close(self) -> None:
        """Stop sending. Pending deliveries are sent after the next start."""
        await self._tasks.close()
        await self._sender.close()


def _new(webhook_id: str, event_type: EventType, alert_id: str | None, at: datetime, event: Document) -> DeliveryEntry:
    return DeliveryEntry(
        webhook_id=webhook_id,
        type=event_type,
        alert_id=alert_id,
        created_at=at,
        event=orjson.loads(encode({"type": event_type, "timestamp": at} | event)),
        state=DeliveryState.PENDING,
        attempts=0,
        next_at=at,
        tried_at=None,
        status_code=None,
        error=None,
    )
