"""The messages of a latched topic that a new reader gets, as a new subscription would get them from the publishers."""

from collections.abc import Iterator
from contextlib import suppress

from dock_gateway.core.graph import TRANSFORMS
from dock_gateway.graph.received import Received

# The most messages that are kept, and the most bytes of one whose frames are read.
MAX_MESSAGES, MAX_BYTES = 1_000, 500_000
_ANY = frozenset({""})


class EarlierMessages:
    """Keeps the newest message of a topic; of transforms, the newest one of each frame.

    Each publisher of `tf_static` has frames of its own and publishes them once, so that none may displace another's.
    """

    def __init__(self) -> None:
        # By message, oldest first: what it says that no later message does.
        self._newest: dict[Received, set[str]] = {}
        self._by_key: dict[str, Received] = {}

    def __iter__(self) -> Iterator[Received]:
        return iter(tuple(self._newest))

    def add(self, message: Received) -> None:
        """Keep a message, and drop those that say nothing that is still valid."""
        keys = set(_frames(message) or _ANY)
        for key in keys:
            if (before := self._by_key.get(key)) is not None:
                self._newest[before].discard(key)
                if not self._newest[before]:
                    del self._newest[before]
            self._by_key[key] = message
        self._newest[message] = keys
        if len(self._newest) > MAX_MESSAGES:
            oldest = next(iter(self._newest))
            for key in self._newest.pop(oldest):
                del self._by_key[key]

    def clear(self) -> None:
        """Forget all messages."""
        self._newest.clear()
        self._by_key.clear()


def _frames(message: Received) -> set[str]:
    """Return the frames whose transforms a message has; none if it has something else."""
    if message.kind.name == TRANSFORMS and message.size <= MAX_BYTES:
        with suppress(Exception):  # whatever the bytes of others bring about
            return {each.child_frame_id.removeprefix("/") for each in message.kind.decode(message.data).transforms}
    return set()
