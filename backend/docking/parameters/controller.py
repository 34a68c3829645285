"""Parameters that choose the controller: one of ours, or one of another package."""

import enum
from importlib.metadata import entry_points
from typing import Any

GROUP = "docking.plans"
"""The group of entry points of other packages' controllers."""


class ControllerName(enum.StrEnum):
    """Our own controllers."""

    ROTATE = "rotate"
    DOCK_POSE = "dock_pose"
    INFRARED = "infrared"


SENSORS = frozenset({"odometry", "marker", "infrared", "scan"})
"""What another package's controller may ask for."""


def load_controller(name: str) -> Any:
    """The controller of another package: what its entry point refers to.

    Raises:
        ValueError: Unknown or invalid controller; the caller adds the subject to the message.
    """
    found = entry_points(group=GROUP)
    if name not in found.names:
        known = dict.fromkeys((*ControllerName, *sorted(found.names)))
        raise ValueError(f"is {name!r}, but must be one of: {', '.join(known)}")
    entry = found[name]
    try:
        loaded = entry.load()
        understood = callable(loaded) and frozenset(loaded.sensors) <= SENSORS
    except Exception as error:
        raise ValueError(f"is {name!r}, which cannot be loaded from {entry.value}: {error}") from error
    if not understood:
        raise ValueError(f"is {name!r}, but the sensors of {entry.value} must be among: {', '.join(sorted(SENSORS))}")
    return loaded


def check_controller(name: str) -> None:
    """Raise ValueError where there is no such controller."""
    if name not in set(ControllerName):
        load_controller(name)
