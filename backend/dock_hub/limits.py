"""The limits that users of a hub share, besides those of a gateway."""

from collections.abc import Mapping

from dock_gateway.http.quotas import Limit
from dock_gateway.settings import Settings


def hub_limits(settings: Settings) -> Mapping[str, Limit]:
    """Return it by name: requests that are carried to sites, in all and to one site."""
    streams = settings.max_streams_per_user
    return {
        "requests": Limit("requests to sites in progress", 5000, streams, 500, "too_many_streams"),
        "requests of one": Limit("requests in progress to", 450, min(150, streams), 50, "too_many_streams"),
    }
