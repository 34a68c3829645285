"""Case (e): from start to the first accepted goal, and what the process takes while nothing happens."""

import time
from collections import defaultdict
from collections.abc import Callable, Sequence

from benchmarks.figures import Results
from benchmarks.machine import wait_until_quiet
from benchmarks.options import Options
from benchmarks.systems.base import Impossible, System

CASE = "(e) start, idle"
STARTS = 3
IDLE = 8.0


async def startup(results: Results, make: Sequence[Callable[[], System]], options: Options) -> None:
    """Start each system some times, and watch it while it is idle."""
    seconds: dict[str, list[float]] = defaultdict(list)
    idle: dict[str, tuple[float, float]] = {}
    starts = max(STARTS, options.rounds)
    silent: dict[str, int] = defaultdict(int)
    for round_ in range(starts):
        for new in make:
            wait_until_quiet(options.quiet)
            system = new()
            begun = time.monotonic()
            try:
                await system.start()
                seconds[system.name].append(time.monotonic() - begun)
                if round_ == starts - 1:
                    idle[system.name] = (await system.cpu_during(IDLE, delay=2.0), system.rss)
            except Impossible as why:
                silent[system.name] += 1
                results.missing(CASE, "", system.name, f"{silent[system.name]} of {starts} starts: {why}")
            finally:
                await system.close()
    for name, found in seconds.items():
        results.add(CASE, "start → first accepted goal", name, sorted(found)[len(found) // 2], unit="s")
    for name, (cpu, rss) in idle.items():
        results.add(CASE, "idle CPU", name, cpu, unit="%")
        results.add(CASE, "idle RSS", name, rss, unit="MB")
