"""A thread that survives errors."""

import logging
import threading
import time
from collections.abc import Callable

from rclpy.executors import ExternalShutdownException

log = logging.getLogger(__name__)

# The thread ends after this many crashes within this many seconds.
MAX_CRASHES, CRASH_WINDOW = 5, 10.0


class RosThread(threading.Thread):
    """Runs a function until it is stopped; restarts it after an error.

    Args:
        name: Name of the thread, for logs.
        work: The function, which returns once `stopping` is set and it is woken.
    """

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        super().__init__(name=name, daemon=True)
        self.stopping = False
        self._work = work

    @property
    def alive(self) -> bool:
        """Whether it is running and not stopping."""
        return self.is_alive() and not self.stopping

    def run(self) -> None:
        """Run the function until the thread is stopped or crashes too often."""
        crashes: list[float] = []
        while not self.stopping:
            try:
                self._work()
            except ExternalShutdownException:
                return
            except Exception:
                if self.stopping:
                    return
                log.exception("an error in the thread %s, which continues", self.name)
                now = time.monotonic()
                crashes = [at for at in crashes if now - at < CRASH_WINDOW] + [now]
                if len(crashes) >= MAX_CRASHES:
                    log.critical(
                        "the thread %s failed %d times in %.0f s and is ended", self.name, len(crashes), CRASH_WINDOW
                    )
                    return

    def end(self) -> bool:
        """Wait up to a second for the end of a thread that is stopping and was woken; return whether it ended."""
        if self.is_alive():
            self.join(1.0)
        if self.is_alive():
            log.warning("the thread %s did not end in time", self.name)
        return not self.is_alive()
