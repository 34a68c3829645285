"""The metrics of a hub: its sites, besides what it has in common with a gateway."""

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.core import GaugeMetricFamily

from dock_gateway.observability.collector import PartsCollector, counters, gauge, gauges
from dock_gateway.observability.request_metrics import NAMESPACE
from dock_gateway.sites.broker import Broker
from dock_hub.sites import Sites


class HubCollector(PartsCollector):
    """Reads the parts of a hub."""

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics as they are now. Call it on the event loop."""
        yield from super().collect()
        sites = self.parts[Sites]
        yield gauge("broker_connected", "Whether the NATS server is connected", self.parts[Broker].connected)
        yield gauges("sites", "Sites by state", "state", sites.count())
        yield counters("sites_refused", "Messages of sites that were refused, by reason", "reason", sites.refused())
        documents = [sites.document(name) for name in sites.names()]
        for name, text, field in (
            ("site_lag_seconds", "Age of a site's newest report", "lag_ms"),
            ("site_round_trip_seconds", "What a small answer of a site took last", "round_trip_ms"),
        ):
            family = GaugeMetricFamily(f"{NAMESPACE}_{name}", text, labels=["site"])
            for site in documents:
                if (value := site[field]) is not None:
                    family.add_metric([site["name"]], value / 1000)
            yield family
