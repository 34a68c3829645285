"""The metrics of the connection to the hub."""

from collections.abc import Iterator

from prometheus_client import Metric

from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.observability.collector import counters, gauges
from dock_gateway.observability.schema import HubState


def hub_metrics(link: HubLink | None) -> Iterator[Metric]:
    """Yield whether the hub reaches this site, and what was refused."""
    connected = {} if link is None else {link.site: link.state is HubState.CONNECTED}
    refused = {} if link is None else link.refused
    yield gauges("hub_connected", "Whether the hub reaches this site", "site", connected)
    yield counters("hub_refused", "Messages of the hub that were refused, by reason", "reason", refused)
