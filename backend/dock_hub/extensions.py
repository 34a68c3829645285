"""The extensions of a gateway that a hub has, too: those that need no more than goals, events and alerts."""

from functools import cache

from dock_gateway.extension import Core, Extension, find_extension
from dock_gateway.extension_list import OURS

NAMES = frozenset({"statistics", "webhooks"})


@cache
def hub_extensions() -> tuple[Extension[Core], ...]:
    """Return the extensions of a hub."""
    return tuple(find_extension(name) for name in OURS if name in NAMES)
