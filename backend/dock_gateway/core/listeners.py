"""What others add to a part of the gateway, such as functions to call when something has happened.

A part gets what it needs as arguments. What is made after it, and the part calls or asks, is added here.
"""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, ParamSpec, TypeVar

log = logging.getLogger(__name__)

P = ParamSpec("P")
T = TypeVar("T")


class Hooks(Generic[T]):
    """What others have added, in order.

    An extension adds with `adding`, so that it leaves nothing behind if it fails, or is closed.
    """

    def __init__(self) -> None:
        self._added: list[T] = []

    def append(self, item: T) -> None:
        """Add something for as long as the process runs. Not for extensions."""
        self._added.append(item)

    @contextmanager
    def adding(self, item: T) -> Iterator[None]:
        """Add something while the block runs."""
        self._added.append(item)
        try:
            yield
        finally:
            self._added.remove(item)

    def __iter__(self) -> Iterator[T]:
        """Iterate over what there is now, whatever is added or removed meanwhile."""
        return iter(tuple(self._added))

    def __len__(self) -> int:
        return len(self._added)


class Listeners(Hooks[Callable[P, object]]):
    """Functions that are called, in order, when something has happened. The others are called if one fails.

    Args:
        what: What has happened, for the log.
    """

    def __init__(self, what: str) -> None:
        super().__init__()
        self._what = what

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call them all, whichever of them fail."""
        for listener in self:
            try:
                listener(*args, **kwargs)
            except Exception:
                log.exception("a listener failed: %s", self._what)
