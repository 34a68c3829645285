"""The rules of delivering: which is sent next, when it is retried, which are kept. Pure: no task, clock or socket."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from dock_gateway.extensions.webhooks.delivery import DeliveryEntry, DeliveryState, EventType

# Seconds from each failed attempt to the next one; after the last, the delivery is given up.
RETRY_AFTER = (5, 30, 120, 600, 1800, 3600, 10_800)
# Maximum number of deliveries that are kept, besides those that still count.
MAX_KEPT = 500
GONE = 410


@dataclass(frozen=True)
class ReceiverAnswer:
    """The outcome of one attempt: the HTTP status, if there was an answer, and the error, if it failed."""

    status_code: int | None
    error: str | None


def open_alerts(deliveries: Mapping[str, DeliveryEntry]) -> dict[str, DeliveryEntry]:
    """Return the deliveries of raised alerts that no cleared one followed, by their ids."""
    newest = {
        (delivery.webhook_id, delivery.alert_id): (identity, delivery)
        for identity, delivery in sorted(deliveries.items(), key=lambda item: item[1].created_at)
        if delivery.alert_id is not None
    }
    return {identity: delivery for identity, delivery in newest.values() if delivery.type is EventType.RAISED}


def find_open(deliveries: Mapping[str, DeliveryEntry], webhook_id: str, alert_id: str) -> DeliveryEntry | None:
    """Return the delivery that last reported an alert to a webhook as raised; None if it was cleared since."""
    for delivery in open_alerts(deliveries).values():
        if (delivery.webhook_id, delivery.alert_id) == (webhook_id, alert_id):
            return delivery
    return None


def due(deliveries: Mapping[str, DeliveryEntry], now: datetime) -> Iterator[tuple[str, DeliveryEntry]]:
    """Yield the deliveries to be sent now, oldest first.

    One waits while an earlier one about the same alert does, so that the end of an alert never comes before its
    beginning.
    """
    waiting: set[tuple[str, str]] = set()
    for identity, delivery in sorted(deliveries.items(), key=lambda item: item[1].created_at):
        if delivery.state is not DeliveryState.PENDING or delivery.alert_id is None:
            continue
        about = (delivery.webhook_id, delivery.alert_id)
        if about not in waiting and delivery.next_at is not None and delivery.next_at <= now:
            yield identity, delivery
        waiting.add(about)


def after_attempt(
    delivery: DeliveryEntry, answer: ReceiverAnswer, now: datetime, retry_after: Sequence[float] = RETRY_AFTER
) -> DeliveryEntry:
    """Return a delivery as it is after an attempt. A test is not sent again, nor what an address refuses for good."""
    attempts = delivery.attempts + 1
    again = (
        answer.error is not None
        and answer.status_code != GONE
        and delivery.type is not EventType.TEST
        and attempts <= len(retry_after)
    )
    if answer.error is None:
        state = DeliveryState.DELIVERED
    else:
        state = DeliveryState.PENDING if again else DeliveryState.FAILED
    return delivery.model_copy(
        update={
            "state": state,
            "attempts": attempts,
            "next_at": now + timedelta(seconds=retry_after[attempts - 1]) if again else None,
            "tried_at": now,
            "status_code": answer.status_code,
            "error": answer.error,
        }
    )


def surplus(deliveries: Mapping[str, DeliveryEntry]) -> list[str]:
    """Return the ids of the oldest deliveries beyond those that are kept.

    Of an alert that is open, or has a delivery that is still to be sent, only what came before that is removed.
    """
    still_open = open_alerts(deliveries)
    counting: set[tuple[str, str | None]] = set()
    ended: list[str] = []
    for identity, delivery in sorted(deliveries.items(), key=lambda item: item[1].created_at):
        about = (delivery.webhook_id, delivery.alert_id)
        if delivery.state is DeliveryState.PENDING or identity in still_open:
            counting.add(about)
        if about not in counting:
            ended.append(identity)
    return ended[:-MAX_KEPT]
