"""The settings of a hub: those of a gateway that a hub reads, and its own."""

from functools import cache
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from dock_gateway.extension_list import ours_with_settings, with_extensions
from dock_gateway.setting_types import Brokers
from dock_gateway.settings import Settings, data_file
from dock_gateway.sites.settings import BrokerSettings

# The extensions of a gateway that a hub has, too: those that need no ROS and no goal that runs here.
EXTENSIONS = frozenset({"audit_log", "single_sign_on", "statistics", "webhooks"})


class HubSettings(BrokerSettings, Settings):
    """The settings of a hub, fixed once it runs. docs/extensions/sites.md lists its own."""

    group: ClassVar[str] = "Sites"
    many_sites: ClassVar[bool] = True

    nats: Brokers = Field((), description="NATS servers, separated by commas, over which the hub reaches its sites.")
    hub_private_key: Path | None = Field(
        None,
        description="File of the private key with which the hub signs who asks, made at the first start. Empty: "
        "`hub.key` in the user's data directory.",
    )

    @property
    def brokers(self) -> dict[str, Brokers]:
        """The NATS servers, by the name of the setting."""
        return {"nats": self.nats}

    @property
    def hub_key_file(self) -> Path:
        """The file with the private key."""
        return self.hub_private_key or data_file("hub.key")


@cache
def hub_settings_type() -> type[HubSettings]:
    """Return the settings of a hub with those of its extensions."""
    return with_extensions("HubSettings", HubSettings, ours_with_settings(sorted(EXTENSIONS)))
