"""What the machine does beside: processor time and memory of a process from /proc, and whether it is quiet."""

import os
import platform
import time
from dataclasses import dataclass
from pathlib import Path

TICK = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Cpu:
    """Processor time that a process has used, and when that was read."""

    seconds: float
    at: float

    @classmethod
    def of(cls, pid: int) -> "Cpu":
        """Read it now."""
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return cls((int(fields[11]) + int(fields[12])) / TICK, time.monotonic())

    def percent_since(self, before: "Cpu") -> float:
        """Share of one core since then, in percent."""
        return 100 * (self.seconds - before.seconds) / max(1e-9, self.at - before.at)


def rss_mb(pid: int) -> float:
    """Resident memory of a process in MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS")) / 1000


def _busy() -> tuple[int, int]:
    fields = [int(field) for field in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    return sum(fields) - fields[3] - fields[4], sum(fields)


def wait_until_quiet(bound: float, share: float = 0.1) -> float:
    """Wait, up to a bound, for a second in which the machine was busy for less than a share; return the last share."""
    deadline = time.monotonic() + bound
    while True:
        before = _busy()
        time.sleep(1.0)
        after = _busy()
        busy = (after[0] - before[0]) / max(1, after[1] - before[1])
        if busy < share or time.monotonic() >= deadline:
            return busy


def describe() -> dict[str, object]:
    """The machine, for the record."""
    model = next(
        (
            line.split(":", 1)[1].strip()
            for line in Path("/proc/cpuinfo").read_text().splitlines()
            if "model name" in line
        ),
        platform.machine(),
    )
    return {"cpu": model, "cores": os.cpu_count(), "kernel": platform.release(), "python": platform.python_version()}
