"""Case (f): many robots, each in its namespace with feedback at 10 Hz, through one client or gateway."""

import time
from collections.abc import Sequence

from benchmarks.cases import add_reading, take_turns
from benchmarks.figures import Results
from benchmarks.options import Options
from benchmarks.site import ACTION, Goal
from benchmarks.systems.bare import Bare
from benchmarks.systems.gateway import Gateway

RATE = 10


async def robots(results: Results, systems: Sequence[Bare | Gateway], options: Options) -> None:
    """One goal on each robot, all feedback read by one reader. Each turn starts the system anew."""
    case = f"(f) {options.robots} robots x {RATE} Hz"
    names = [f"/robot{number}/{ACTION}" for number in range(1, options.robots + 1)]
    # Goals go out one after another: a delay lets all of them be there before the first feedback.
    goal = Goal(RATE, int(RATE * options.seconds), 4.0)

    async def measure(system: Bare | Gateway) -> None:
        begun = time.monotonic()
        try:
            await system.start_robots(names)
            if isinstance(system, Gateway):  # the bare client looks for nothing that it was not told of
                results.add(case, "start → all actions known", system.name, time.monotonic() - begun, "s")
            add_reading(results, case, system.name, await system.read_robots(goal, names))
            results.add(case, "RSS", system.name, system.rss, "MB")
        finally:
            await system.close()

    await take_turns(results, case, systems, options, measure)
