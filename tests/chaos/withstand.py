"""What others see of a gateway during a flood, and whether it has recovered afterwards."""

import os
import time
from collections.abc import Callable
from contextlib import AbstractContextManager

from tests.chaos.report import report
from tests.support.gateway import RunningGateway
from tests.support.probe import memory, open_files, probing, quantile
from tests.support.waiting import wait_until

SECONDS = float(os.environ.get("CHAOS_SECONDS", "1"))
# The promise is 100 ms. A long run gets ten times that; a short one, whose 99th percentile is the worst of ten answers
# on a machine that other tests share, thirty times.
STOPPED_WITHIN = 1.0 if SECONDS >= 5 else 3.0
# How often a flood is repeated whose memory does not come back.
REPEATS = 3

Flood = Callable[[], AbstractContextManager[object]]


def withstand(gateway: RunningGateway, name: str, flood: Flood, megabytes: float = 20) -> None:
    """Measure stops, health and a stream during a flood, then see that memory and files come back."""
    pid = gateway.process.pid
    files = open_files(pid)

    def take() -> None:
        _measure(gateway, name, flood)
        wait_until(lambda: open_files(pid) <= files + 10, f"no more than {files + 10} open files")

    leave_nothing(take, lambda: memory(pid), megabytes)


def leave_nothing(flood: Callable[[], None], used: Callable[[], float], megabytes: float, patience: float = 12) -> None:
    """See that the memory of a flood comes back, or is used again by the same flood: then it is no leak.

    The allocator may keep what a flood needed at its height, more of it the busier the machine. What it keeps serves
    the next flood, while a leak takes the same again.

    Args:
        flood: Floods once.
        used: Returns the memory in use, in MB.
        megabytes: What one flood may leave behind; a repetition may leave a quarter of it.
        patience: Seconds to wait for the memory: goals that nobody knows are lost after 8 s, and forgotten.
    """
    levels = [used()]
    for allowed in (megabytes, *[megabytes / 4] * REPEATS):
        flood()
        deadline = time.monotonic() + patience
        while (now := used()) > levels[-1] + allowed and time.monotonic() < deadline:
            time.sleep(0.1)
        levels.append(now)
        if now <= levels[-2] + allowed:
            return
    raise AssertionError(f"each flood takes more memory: {', '.join(f'{level:.1f}' for level in levels)} MB")


def _measure(gateway: RunningGateway, name: str, flood: Flood) -> None:
    with probing(gateway) as findings, flood():
        time.sleep(SECONDS)
        wait_until(lambda: findings.complete, "an answer to each probe")
    report(name, findings.figures())
    assert findings.errors == [], findings.errors
    assert quantile(findings.stop, 0.99) < STOPPED_WITHIN
    assert max(findings.health) < 2 * STOPPED_WITHIN
    assert max(findings.gaps) < 2 * STOPPED_WITHIN
