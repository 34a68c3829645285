"""A watchdog: acts in a thread of its own when it was not fed in time."""

import threading
import time
from collections.abc import Callable


class Watchdog:
    """Calls a function once each time that nobody has fed it for too long."""

    def __init__(self, timeout: float, on_silence: Callable[[], None]) -> None:
        """Start the thread, with the watchdog asleep.

        Args:
            timeout: How long it bears to be left alone, in seconds.
            on_silence: Called in the watchdog's thread; it must not raise.
        """
        self._timeout = timeout
        self._on_silence = on_silence
        self._deadline: float | None = None
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)
        self._thread.start()

    def feed(self) -> None:
        """All is well until the time-out, counted from now."""
        with self._changed:
            asleep, self._deadline = self._deadline is None, time.monotonic() + self._timeout
            if asleep:
                self._changed.notify()

    def sleep(self) -> None:
        """Nobody needs to feed it until somebody does again."""
        with self._changed:
            self._deadline = None

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join()

    def _watch(self) -> None:
        while self._wait():
            self._on_silence()

    def _wait(self) -> bool:
        """Wait for a silence that is too long; whether it was one, and not the end."""
        with self._changed:
            while not self._closed:
                if self._deadline is None:
                    self._changed.wait()
                elif (left := self._deadline - time.monotonic()) > 0.0:
                    self._changed.wait(left)
                else:
                    self._deadline = None
                    return True
            return False
