"""The one list of extensions: nothing else names them.

A command that only reads settings imports no more than those: an extension takes its time to import.
"""

from functools import cache
from importlib import import_module
from importlib.util import find_spec

from dock_gateway.settings import ExtensionSettings, Settings

OURS = (
    "recordings",
    "statistics",
    "maps",
    "cameras",
    "automation",
    "webhooks",
    "rosbridge",
    "foxglove",
    "agents",
)
PACKAGE = "dock_gateway.extensions"


@cache
def settings_type() -> type[Settings]:
    """Return the settings of a gateway with those of its extensions."""
    names = [f"{PACKAGE}.{name}.settings" for name in OURS]
    modules = [import_module(name) for name in names if find_spec(name) is not None]
    further = [kind for module in modules for kind in vars(module).values() if _is_settings(kind)]
    return type("GatewaySettings", (*further, Settings), {"__doc__": Settings.__doc__})


def _is_settings(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, ExtensionSettings) and kind is not ExtensionSettings
