"""A NATS server with a login for a hub and for each site, with the permissions that docs/extensions/sites.md names."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dock_hub.demonstration import broker_permissions, new_login
from tests.support.nats import NatsServer


class SiteBroker(NatsServer):
    """The server.

    Args:
        folder: Where its configuration and its log are.
        sites: The names of the sites.
    """

    def __init__(self, folder: Path, *sites: str) -> None:
        self._logins = {name: new_login(name) for name in ("hub", *sites)}
        hub, *others = self._logins.values()
        super().__init__(folder, f"authorization: {json.dumps(broker_permissions(hub, others))}")

    def url_for(self, name: str, port: int | None = None) -> str:
        """Where a site, or `hub`, connects to; with a port, by a link there."""
        return self._logins[name].url(port or self.port)


@contextmanager
def site_broker(folder: Path, *sites: str) -> Iterator[SiteBroker]:
    """A server that runs until the block ends."""
    with SiteBroker(folder, *sites) as broker:
        yield broker
