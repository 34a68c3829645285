"""Those who want to know when something has happened."""

import logging
from collections.abc import Callable
from typing import Generic, ParamSpec

log = logging.getLogger(__name__)

P = ParamSpec("P")


class Listeners(Generic[P]):
    """Functions that are called, in order, when something has happened. The others are called if one fails.

    Args:
        what: What has happened, for the log.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._listeners: list[Callable[P, object]] = []

    def append(self, listener: Callable[P, object]) -> None:
        """Add a listener."""
        self._listeners.append(listener)

    def remove(self, listener: Callable[P, object]) -> None:
        """Remove a listener."""
        self._listeners.remove(listener)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call them all, whichever of them fail."""
        for listener in tuple(self._listeners):
            try:
                listener(*args, **kwargs)
            except Exception:
                log.exception("a listener failed: %s", self._what)
