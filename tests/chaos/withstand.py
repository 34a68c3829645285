"""What others see of a gateway during a flood, and whether it has recovered afterwards."""

import os
import time
from contextlib import AbstractContextManager

from tests.chaos.report import report
from tests.support.gateway import RunningGateway
from tests.support.probe import memory, open_files, probing, quantile
from tests.support.waiting import wait_until

SECONDS = float(os.environ.get("CHAOS_SECONDS", "1"))
# The promise is 100 ms. A long run gets ten times that; a short one, whose 99th percentile is the worst of ten answers
# on a machine that other tests share, thirty times.
STOPPED_WITHIN = 1.0 if SECONDS >= 5 else 3.0


def withstand(gateway: RunningGateway, name: str, flood: AbstractContextManager[object], megabytes: float = 20) -> None:
    """Measure stops, health and a stream during a flood, then wait until memory and files are back."""
    before, files = memory(gateway.process.pid), open_files(gateway.process.pid)
    with probing(gateway) as findings, flood:
        time.sleep(SECONDS)
        wait_until(lambda: findings.complete, "an answer to each probe")
    report(name, findings.figures())
    assert findings.errors == [], findings.errors
    assert quantile(findings.stop, 0.99) < STOPPED_WITHIN
    assert max(findings.health) < 2 * STOPPED_WITHIN
    assert max(findings.gaps) < 2 * STOPPED_WITHIN
    deadline = time.monotonic() + 30  # goals that nobody knows are lost after 8 s, and forgotten
    while memory(gateway.process.pid) > before + megabytes or open_files(gateway.process.pid) > files + 10:
        assert time.monotonic() < deadline, (before, memory(gateway.process.pid), open_files(gateway.process.pid))
        time.sleep(0.1)
