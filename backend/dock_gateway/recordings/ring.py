"""The last seconds of what was heard of a robot, as serialized messages in memory. No ROS, no file."""

import time
from collections import deque
from collections.abc import Callable
from itertools import takewhile
from typing import NamedTuple

from robot_io.recording import Sample

# Bytes that a message takes in memory besides its data.
OVERHEAD = 250
# The newest messages of a topic whose messages hold until the next one. Each publisher of transforms has its own.
LASTING = 50


class _Entry(NamedTuple):
    number: int
    at: float
    sample: Sample

    @property
    def size(self) -> int:
        return len(self.sample.data) + OVERHEAD


class Ring:
    """The newest messages, limited in time and in bytes.

    Args:
        seconds: The maximum age of a message.
        max_bytes: The maximum size of all messages, with what they take besides. A larger message is not kept. The
            messages of a topic that hold until the next one may have as much again.
        clock: Returns seconds that never go back.

    Attributes:
        size: Bytes of all messages, with what they take besides.
        heard: Number of messages so far.
    """

    def __init__(self, seconds: float, max_bytes: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.size = 0
        self.heard = 0
        self._seconds = seconds
        self._max_bytes = max_bytes
        self._clock = clock
        self._entries: deque[_Entry] = deque()
        self._lasting: dict[str, dict[bytes, Sample]] = {}

    def __len__(self) -> int:
        return len(self._entries)

    def put(self, sample: Sample, *, lasting: bool = False) -> None:
        """Add a message, and drop those that are too old or too many.

        Args:
            sample: The message.
            lasting: Whether it holds until the next one of its topic, however old it is.
        """
        self.heard += 1
        entry = _Entry(self.heard, self._clock(), sample)
        if entry.size > self._max_bytes:
            return
        self._entries.append(entry)
        self.size += entry.size
        while self.size > self._max_bytes or self._entries[0].at < entry.at - self._seconds:
            self.size -= self._entries.popleft().size
        if lasting:
            kept = self._lasting.setdefault(sample.topic, {})
            kept.pop(sample.data, None)  # publishers repeat them
            kept[sample.data] = sample
            while len(kept) > LASTING or sum(map(len, kept)) > self._max_bytes:
                del kept[next(iter(kept))]

    def mark(self, seconds: float = 0.0) -> int:
        """Return the number of the last message that is older than this; `after` returns those that follow."""
        since = self._clock() - seconds
        return self.heard - sum(1 for _ in takewhile(lambda entry: entry.at >= since, reversed(self._entries)))

    def after(self, number: int) -> list[Sample]:
        """Return the messages after the one with this number that are still there, oldest first."""
        newer = takewhile(lambda entry: entry.number > number, reversed(self._entries))
        return [entry.sample for entry in newer][::-1]

    def lasting(self) -> list[Sample]:
        """Return the messages that hold until the next one of their topic."""
        return [sample for kept in self._lasting.values() for sample in kept.values()]
