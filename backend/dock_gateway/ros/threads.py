"""A thread that survives errors."""

import logging
import threading
import time
from collections.abc import Callable

from rclpy.executors import ExternalShutdownException

log = logging.getLogger(__name__)

# So many crashes within so many seconds, and the thread is given up.
MAX_CRASHES, CRASH_WINDOW = 5, 10.0


class RosThread(threading.Thread):
    """Does some work until it is told to stop, again after an error.

    Args:
        name: Name of the thread, for logs.
        work: Comes back when `stopping` was set and it was woken.
    """

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        super().__init__(name=name, daemon=True)
        self.stopping = False
        self._work = work

    @property
    def alive(self) -> bool:
        """Whether it runs and is to go on."""
        return self.is_alive() and not self.stopping

    def run(self) -> None:
        """Work."""
        crashes: list[float] = []
        while not self.stopping:
            try:
                self._work()
            except ExternalShutdownException:
                return
            except Exception:
                if self.stopping:
                    return
                log.exception("the thread %s hit an error and goes on", self.name)
                now = time.monotonic()
                crashes = [at for at in crashes if now - at < CRASH_WINDOW] + [now]
                if len(crashes) >= MAX_CRASHES:
                    log.critical(
                        "the thread %s failed %d times in %.0f s and is given up", self.name, len(crashes), CRASH_WINDOW
                    )
                    return

    def end(self) -> bool:
        """Wait a moment for the end, once it is stopping and was woken; whether it came."""
        if self.is_alive():
            self.join(1.0)
        if self.is_alive():
            log.warning("the thread %s did not end; leaving it behind", self.name)
        return not self.is_alive()
