"""The metrics of webhooks."""

from collections.abc import Iterator

from prometheus_client import Metric

from dock_gateway.extensions.webhooks.delivery import DeliveryState
from dock_gateway.extensions.webhooks.webhooks import Webhooks
from dock_gateway.observability.collector import counters

OUTCOMES = {
    DeliveryState.DELIVERED: "delivered",
    DeliveryState.PENDING: "to_be_repeated",
    DeliveryState.FAILED: "given_up",
}


def webhook_metrics(webhooks: Webhooks) -> Iterator[Metric]:
    """Yield how often an alert was sent."""
    attempts = {outcome: webhooks.attempts.get(state, 0) for state, outcome in OUTCOMES.items()}
    yield counters("webhook_attempts", "Attempts to send an alert to a webhook", "outcome", attempts)
