"""The extensions of a gateway that a hub has, too: those that need no ROS and no goal that runs here."""

from dock_gateway.extension import Installed
from dock_gateway.extension_list import OURS

NAMES = frozenset({"audit_log", "statistics", "webhooks"})


def hub_extensions() -> Installed:
    """Import the extensions of a hub."""
    return Installed.load(name for name in OURS if name in NAMES)
