"""What every measured system can be asked."""

import asyncio
import sys
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Self

from tests.support.processes import Process

from benchmarks.machine import Cpu, rss_mb
from benchmarks.site import Goal, Site


class Impossible(Exception):
    """The system cannot do this; the message says why, for the table."""


@dataclass
class Timing:
    """Milliseconds from the submission of a goal; None where the system does not say."""

    accepted: float | None
    result: float | None


@dataclass
class Reading:
    """What the readers of one run received. `latencies` in ms, of all but the first tenth."""

    expected: int
    received: int
    latencies: list[float] = field(default_factory=list)
    achieved_hz: float = 0.0
    cpu: float = 0.0

    @property
    def lost(self) -> int:
        """How many messages never arrived."""
        return max(0, self.expected - self.received)

    @classmethod
    def of(cls, expected: int, latencies: list[float], stamps: list[int], cpu: float) -> Self:
        """Out of what was noted."""
        ordered = sorted(stamps)
        seconds = (ordered[-1] - ordered[0]) / 1e9 if len(ordered) > 1 else 0.0
        achieved = (len(ordered) - 1) / seconds if seconds else 0.0
        return cls(expected, len(latencies), latencies[len(latencies) // 10 :], achieved, cpu)


class System(ABC):
    """One system, started at a site."""

    name: str
    process: Process
    max_readers = sys.maxsize

    def __init__(self, where: Site) -> None:
        self.site = where

    @abstractmethod
    async def start(self) -> None:
        """Start it, and come back when it has had its first goal accepted."""

    @abstractmethod
    async def submit(self) -> Timing:
        """One goal without feedback, to its result."""

    async def one_goal(self) -> None:
        """One goal, with its result, read once."""
        await self.submit()

    @abstractmethod
    async def stream(self, goal: Goal, readers: int) -> Reading:
        """Read the feedback of one goal."""

    async def close(self) -> None:
        """End it."""
        await asyncio.to_thread(self.process.__exit__)

    @property
    def pid(self) -> int:
        """The process that is measured."""
        return self.process.pid

    @property
    def rss(self) -> float:
        """Its memory in MB."""
        return rss_mb(self.pid)

    async def cpu_during(self, seconds: float, delay: float = 0.0) -> float:
        """Its processor use, in percent of a core, over some seconds."""
        await asyncio.sleep(delay)
        before = Cpu.of(self.pid)
        await asyncio.sleep(seconds)
        return Cpu.of(self.pid).percent_since(before)
