"""The webhooks, as people see, change and test them, each with what was and is to be sent to it."""

import logging
from collections.abc import Mapping

from dock_gateway.core.cursor import Cursor, newest
from dock_gateway.core.errors import Conflict
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.webhooks.delivery import DeliveryState, Document
from dock_gateway.extensions.webhooks.notifier import Notifier
from dock_gateway.extensions.webhooks.outbox import Outbox
from dock_gateway.extensions.webhooks.sender import new_secret
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_WEBHOOKS = 20


class Webhooks:
    """The webhooks of all gateways that share the history.

    Args:
        book: Stores them.
        outbox: Sends to them.
        notifier: Sends them alerts.
    """

    def __init__(self, book: SharedBook[WebhookEntry], outbox: Outbox, notifier: Notifier) -> None:
        self._book = book
        self._outbox = outbox
        self._notifier = notifier
        self._testing: set[str] = set()

    @property
    def attempts(self) -> Mapping[DeliveryState, int]:
        """Number of attempts to send, by the state of the delivery after it."""
        return self._outbox.attempts

    async def documents(self) -> list[Document]:
        """Return the webhooks as `GET /webhooks` shows them, by name.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhooks = await self._book.read()
        await self._outbox.read()
        ordered = sorted(webhooks.items(), key=lambda item: (item[1].name.casefold(), item[0]))
        return [self._document(webhook_id, webhook) for webhook_id, webhook in ordered]

    async def document(self, webhook_id: str) -> Document:
        """Return a webhook as `GET /webhooks/{webhook_id}` shows it.

        Raises:
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhook = await self._book.find(webhook_id)
        await self._outbox.read()
        return self._document(webhook_id, webhook)

    async def replace(
        self, webhook_id: str, webhook: WebhookEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[Document, bool]:
        """Store a webhook, new or changed; return it, with its secret if that was made now, and whether it is new.

        Args:
            webhook_id: Its id.
            webhook: The webhook; with an empty secret, it keeps the one that it has, or gets a random one.
            condition: The version that it must have.

        Raises:
            ChangedMeanwhile: The condition is not true.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the webhook is what it was.
        """
        known = (await self._book.read()).get(webhook_id)
        made = None
        if not webhook.secret:
            made = None if known is not None else new_secret()
            secret = made or (known.secret if known is not None else "")
            webhook = webhook.model_copy(update={"secret": secret})
        new = await self._book.replace(webhook_id, webhook, condition=condition)
        state = "on" if webhook.enabled else "off"
        log.info("webhook %s (%r): %s, by %s", webhook_id, webhook.name, state, webhook.changed_by)
        await self._outbox.tidy()
        self._notifier.compare()
        return self._document(webhook_id, webhook) | {"secret": made}, new

    async def remove(self, webhook_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a webhook with its deliveries.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the webhook is still there.
        """
        await self._book.remove(webhook_id, condition)
        log.info("webhook %s removed", webhook_id)
        await self._outbox.tidy()

    def _document(self, webhook_id: str, webhook: WebhookEntry) -> Document:
        own = self._outbox.sent_to(webhook_id)
        tried = [(each.tried_at, identity, each) for identity, each in own if each.tried_at is not None]
        _, identity, last = max(tried, key=lambda each: each[0], default=(None, "", None))
        return {
            "id": webhook_id,
            "etag": self._book.etag(webhook),
            **webhook.model_dump(exclude={"secret"}),
            "pending": sum(each.state is DeliveryState.PENDING for _, each in own),
            "last_delivery": None if last is None else last.document(identity),
        }

    async def deliveries(
        self, webhook_id: str, limit: int, end: Cursor | None = None
    ) -> tuple[list[Document], Cursor | None]:
        """Return the deliveries of a webhook as `GET /webhooks/{webhook_id}/deliveries` shows them, newest first.

        Args:
            webhook_id: Its id.
            limit: The length of a page.
            end: Where the page before ended; None for the first one.

        Returns:
            The page, and where it ends; None if it is the last one.

        Raises:
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self._book.find(webhook_id)
        await self._outbox.read()
        found = dict(self._outbox.sent_to(webhook_id))
        places, end = newest((Cursor(each.created_at, identity) for identity, each in found.items()), limit, end)
        return [found[each.id].document(each.id) for each in places], end

    async def test(self, webhook_id: str) -> Document:
        """Send a test now, once, also to a webhook that is off; return the delivery.

        Raises:
            NotFound: `webhook_not_found`.
            Conflict: Another test is being sent (`test_running`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhook = await self._book.find(webhook_id)
        if webhook_id in self._testing:
            raise Conflict("another test is being sent to this webhook", code="test_running")
        self._testing.add(webhook_id)
        try:
            return await self._outbox.send_test(webhook_id, webhook)
        finally:
            self._testing.discard(webhook_id)
