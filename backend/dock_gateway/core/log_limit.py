"""Limits repeated log lines, so that a flood of messages does not flood the log."""

import contextlib
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

# Maximum number of lines of one kind in a period, and the period in seconds.
MAX_LINES, PERIOD = 20, 10.0
# Maximum number of kinds that are counted at the same time.
MAX_KINDS = 1000


@dataclass
class Count:
    """Number of lines of one kind since a time, written or not."""

    since: float
    lines: int = 0


class LogLimit(logging.Filter):
    """Passes `MAX_LINES` lines of a kind in each period and reports how many it leaves out.

    A kind is a logger and a message before its arguments are filled in.

    Args:
        clock: Returns seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._lock = threading.Lock()
        self._counts: dict[tuple[str, str], Count] = {}

    @property
    def kinds(self) -> int:
        """Number of kinds that are counted."""
        return len(self._counts)

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a line is written."""
        now, kind = self._clock(), (record.name, str(record.msg))
        with self._lock:
            count = self._counts.get(kind)
            left_out = 0
            if count is None or now - count.since >= PERIOD:
                left_out = 0 if count is None else max(0, count.lines - MAX_LINES)
                if len(self._counts) >= MAX_KINDS:
                    self._forget(now)
                count = self._counts[kind] = Count(now)
            count.lines += 1
        if left_out:
            _add(record, f"{left_out} similar lines were suppressed")
        if count.lines == MAX_LINES:
            _add(record, f"similar lines are suppressed for {PERIOD + count.since - now:.0f} s")
        return count.lines <= MAX_LINES

    def _forget(self, now: float) -> None:
        self._counts = {kind: count for kind, count in self._counts.items() if now - count.since < PERIOD}
        if len(self._counts) >= MAX_KINDS:
            self._counts.clear()


def _add(record: logging.LogRecord, remark: str) -> None:
    with contextlib.suppress(TypeError, ValueError):  # the handler reports arguments that do not fit
        record.msg, record.args = f"{record.getMessage()} ({remark})", ()
