"""Case (e): from start to the first accepted goal, and what the process uses while nothing happens."""

import time
from collections.abc import Sequence

from benchmarks.cases import take_turns
from benchmarks.figures import Results
from benchmarks.options import Options
from benchmarks.systems.base import System

CASE = "(e) start, idle"
IDLE = 8.0


async def startup(results: Results, systems: Sequence[System], options: Options) -> None:
    """Start each system in each turn, and watch it while it is idle."""

    async def measure(system: System) -> None:
        begun = time.monotonic()
        try:
            await system.start()
            results.add(CASE, "start → first accepted goal", system.name, time.monotonic() - begun, "s")
            results.add(CASE, "idle CPU", system.name, await system.cpu_during(IDLE, delay=2.0), "%")
            results.add(CASE, "idle RSS", system.name, system.rss, "MB")
        finally:
            await system.close()

    await take_turns(results, CASE, systems, options, measure)
