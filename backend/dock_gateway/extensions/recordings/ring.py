"""The last seconds of what was heard of a robot, as serialized messages in memory. No ROS, no file."""

import time
from collections import deque
from collections.abc import Callable
from itertools import takewhile
from typing import NamedTuple

from robot_io.recording import Sample

# Bytes that a message takes in memory besides its data.
OVERHEAD = 250


class _Entry(NamedTuple):
    number: int
    at: float
    sample: Sample
    kept: int

    @property
    def size(self) -> int:
        return len(self.sample.data) + OVERHEAD


class Ring:
    """The newest messages, limited in time and in bytes.

    Args:
        seconds: The maximum age of a message.
        max_bytes: The maximum size of all messages, with what they take besides. A larger message is not kept. Older
            messages that publishers keep for later subscribers may have as much again.
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
        self._held: dict[str, dict[bytes, Sample]] = {}  # older than the entries, by topic

    def __len__(self) -> int:
        return len(self._entries)

    def put(self, sample: Sample, *, kept: int = 0) -> None:
        """Add a message, and drop those that are too old or too many.

        Args:
            sample: The message.
            kept: Number of messages that the publishers of its topic keep for later subscribers: that many outlast
                their time here.
        """
        self.heard += 1
        entry = _Entry(self.heard, self._clock(), sample, kept)
        if entry.size > self._max_bytes:
            return
        self._entries.append(entry)
        self.size += entry.size
        while self.size > self._max_bytes or self._entries[0].at < entry.at - self._seconds:
            dropped = self._entries.popleft()
            self.size -= dropped.size
            if dropped.kept:
                _hold(self._held, dropped)
                self._limit_held()

    def _limit_held(self) -> None:
        sizes = {topic: sum(map(len, held)) for topic, held in self._held.items()}
        while sum(sizes.values()) > self._max_bytes:
            topic = max(sizes, key=sizes.__getitem__)
            oldest = next(iter(self._held[topic]))
            del self._held[topic][oldest]
            sizes[topic] -= len(oldest)

    def mark(self, seconds: float = 0.0) -> int:
        """Return the number of the last message that is older than this; `after` returns those that follow."""
        since = self._clock() - seconds
        return self.heard - sum(1 for _ in takewhile(lambda entry: entry.at >= since, reversed(self._entries)))

    def after(self, number: int) -> list[Sample]:
        """Return the messages after the one with this number that are still there, oldest first."""
        newer = takewhile(lambda entry: entry.number > number, reversed(self._entries))
        return [entry.sample for entry in newer][::-1]

    def held(self, number: int) -> list[Sample]:
        """Return what a subscriber would have got that came just after the message with this number.

        Those are the newest messages that publishers keep for later subscribers, each once, oldest first by topic.
        """
        held = {topic: dict(samples) for topic, samples in self._held.items()}
        for entry in takewhile(lambda entry: entry.number <= number, self._entries):
            if entry.kept:
                _hold(held, entry)
        return [sample for samples in held.values() for sample in samples.values()]


def _hold(held: dict[str, dict[bytes, Sample]], entry: _Entry) -> None:
    samples = held.setdefault(entry.sample.topic, {})
    samples.pop(entry.sample.data, None)  # publishers repeat them
    samples[entry.sample.data] = entry.sample
    while len(samples) > entry.kept:
        del samples[next(iter(samples))]
