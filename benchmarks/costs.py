"""Case (k): what it costs, in processor time of the process: a goal, a request, a message of feedback.

Unlike a latency, processor time hardly depends on what else the machine does.
"""

from collections.abc import Sequence

from benchmarks.cases import take_turns
from benchmarks.figures import Results
from benchmarks.machine import Cpu
from benchmarks.options import Options
from benchmarks.site import Goal
from benchmarks.systems.base import System
from benchmarks.systems.gateway import Gateway

CASE = "(k) processor time"
REQUESTS = 1000
# Readers of one goal's feedback, its messages a second, and seconds.
READERS, RATE, SECONDS = 20, 100, 3.0


async def costs(results: Results, systems: Sequence[System], options: Options) -> None:
    """A goal is sent, has its result, and is read once; a request is `GET /healthz`."""
    goals = max(20, options.goals // options.rounds)

    async def measure(system: System) -> None:
        for _ in range(10):
            await system.one_goal()
        before = Cpu.of(system.pid)
        for _ in range(goals):
            await system.one_goal()
        _add(results, system, "a goal", before, goals)
        if not isinstance(system, Gateway):
            return
        before = Cpu.of(system.pid)
        for _ in range(REQUESTS):
            system.healthz()
        _add(results, system, "a request", before, REQUESTS)
        before = Cpu.of(system.pid)
        reading = await system.stream(Goal(RATE, int(RATE * SECONDS), 0.5), READERS)
        _add(results, system, f"a message, {READERS} readers", before, reading.received / READERS)

    await take_turns(results, CASE, systems, options, measure)


def _add(results: Results, system: System, what: str, before: Cpu, number: float) -> None:
    results.add(CASE, what, system.name, 1e3 * (Cpu.of(system.pid).seconds - before.seconds) / number, "ms")
