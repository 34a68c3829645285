"""Knows when a message arrived, which may be long before it is handled."""

import time
from collections.abc import Mapping
from typing import Any


def arrived_at(info: Mapping[str, Any], now: float | None = None) -> float:
    """Return when a message that is handled now was received, in seconds of the clock of `now`.

    Args:
        info: About the message, as a subscription of rclpy gives it.
        now: The current time; None is that of the monotonic clock.
    """
    return received_at(time.monotonic() if now is None else now, time.time(), info.get("received_timestamp", 0) / 1e9)


def received_at(now: float, wall_now: float, received_wall: float) -> float:
    """Return when a message that is handled now was received.

    A message may have waited while the process was busy or frozen, and must not look fresh for it. The middleware
    stamps the reception with the wall clock; only the difference counts, so that a clock set in between
    harms no other message.

    Args:
        now: The monotonic clock, in seconds.
        wall_now: The wall clock at the same moment, in seconds.
        received_wall: The reception by the wall clock, in seconds; 0 where the middleware gives none.

    Returns:
        Seconds of the monotonic clock.
    """
    if received_wall <= 0.0:
        return now
    return now - max(0.0, wall_now - received_wall)
