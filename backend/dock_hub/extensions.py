"""The extensions of a hub."""

from dock_gateway.extension import Installed
from dock_gateway.extension_list import OURS
from dock_hub.settings import EXTENSIONS


def hub_extensions() -> Installed:
    """Import the extensions of a hub."""
    return Installed.load(name for name in OURS if name in EXTENSIONS)
