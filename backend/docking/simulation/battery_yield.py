"""Stepping back where someone else publishes the battery's state."""

from collections import deque

REMEMBERED = 64
"""Own messages that are known again; at ten a second, those of six seconds."""


class BatteryYield:
    """Tells own messages from those of others, and says when it is polite to publish.

    A message is one's own if it is, byte for byte, one that was sent a moment ago: every one of ours has another stamp.
    """

    def __init__(self) -> None:
        self._sent: deque[bytes] = deque(maxlen=REMEMBERED)
        self._other_at: float | None = None

    def sent(self, message: bytes) -> None:
        """A message was published by us."""
        self._sent.append(message)

    def heard(self, message: bytes, now: float) -> None:
        """A message has come, perhaps our own.

        Args:
            message: As it was on the wire.
            now: The moment, in seconds.
        """
        if message not in self._sent:
            self._other_at = now

    def others_publish(self, now: float, resume_after: float) -> bool:
        """Whether someone else has been heard in the last `resume_after` seconds."""
        return self._other_at is not None and now - self._other_at < resume_after
