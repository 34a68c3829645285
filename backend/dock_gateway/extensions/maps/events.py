"""The events of a robot's surroundings."""

from datetime import datetime
from typing import Any

from dock_gateway.core.event import Event
from dock_gateway.core.goal import encode


def surroundings_event(kind: str, payload: dict[str, Any], now: datetime, *, robot: str, source: str | None) -> Event:
    """Return the event of a robot's `map`, `scan` or `path`. Only the newest matters; none is stored.

    Args:
        kind: `map`, `scan` or `path`: the event's type, its topic, and the name of the field with the payload.
        payload: The document.
        now: When it is sent.
        robot: The robot's namespace.
        source: The ROS topic that it was read from, which readers need the right to read, too.
    """
    document = {"type": kind, "time": now, "robot": robot, kind: payload}
    return Event(encode(document), kind, droppable=True, robot=robot, supersedes=True, source=source)
