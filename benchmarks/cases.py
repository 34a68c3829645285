"""The cases. Each measures one system in one turn; `take_turns` gives every system its turns."""

import asyncio
import gc
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from benchmarks.figures import Results
from benchmarks.machine import wait_until_quiet
from benchmarks.options import Options
from benchmarks.site import Goal
from benchmarks.systems.base import Impossible, Reading, System

PAUSE = 0.05  # between goals: an action server that remembers many is slower for everyone
LATENCY_RATES = (10, 100, 1000)
FAN_OUT = ((1, 20), (200, 20), (1000, 20), (200, 100))
LADDER = (500, 750, 1000, 1500, 2000, 2500, 3000, 4000, 5000)
FAILURES = (Impossible, OSError, TimeoutError, AssertionError)


async def take_turns(
    results: Results, case: str, systems: Sequence[Any], options: Options, measure: Callable[[Any], Awaitable[None]]
) -> None:
    """Measure A, B, C, then A, B, C again; what fails is left out of the turn, with the reason."""
    for _ in range(options.rounds):
        for system in systems:
            gc.collect()  # the load client collects garbage only here: its pauses are not the system's
            wait_until_quiet(options.quiet)
            try:
                await measure(system)
            except FAILURES as error:
                results.leave_out(system.name, case, str(error)[:300] or type(error).__name__)


async def acceptance(results: Results, systems: Sequence[System], options: Options, case: str = "(a) goal") -> None:
    """(a) Submit → accepted, and goal → result."""
    goals = max(10, options.goals // options.rounds)

    async def measure(system: System) -> None:
        for _ in range(5):
            await system.submit()
        timings = []
        for _ in range(goals):
            await asyncio.sleep(PAUSE)
            timings.append(await system.submit())
        for what, values in (
            ("submit → accepted", [timing.accepted for timing in timings]),
            ("goal → result", [timing.result for timing in timings]),
        ):
            results.latencies(case, what, system.name, (value for value in values if value is not None))

    await take_turns(results, case, systems, options, measure)


async def latency(results: Results, systems: Sequence[System], options: Options) -> None:
    """(b) Feedback, from the server's publication to one reader."""
    for rate in LATENCY_RATES:
        seconds = max(options.seconds, 4.0) if rate == 10 else options.seconds
        await _streams(
            results, systems, options, f"(b) {rate} Hz", goal=Goal(rate, int(rate * seconds), 0.5), readers=1
        )


async def fan_out(results: Results, systems: Sequence[System], options: Options) -> None:
    """(c) Feedback to many readers."""
    for readers, rate in FAN_OUT:
        goal = Goal(rate, int(rate * options.seconds), 1.0 + readers / 400)
        await _streams(results, systems, options, f"(c) {readers} x {rate} Hz", goal=goal, readers=readers)


async def _streams(
    results: Results, systems: Sequence[System], options: Options, case: str, *, goal: Goal, readers: int
) -> None:
    async def measure(system: System) -> None:
        add_reading(results, case, system.name, await system.stream(goal, readers))

    for system in systems:
        if readers > system.max_readers:
            results.leave_out(system.name, case, "one reader only")
    await take_turns(results, case, [s for s in systems if readers <= s.max_readers], options, measure)


def add_reading(results: Results, case: str, system: str, reading: Reading) -> None:
    """Add what one turn of one system gave."""
    if not reading.received:
        raise Impossible(f"it delivered none of {reading.expected} messages")
    results.latencies(case, "", system, reading.latencies)
    results.add(case, "CPU", system, reading.cpu, "%")
    results.add(case, f"lost of {reading.expected}", system, reading.lost, "lost")


async def highest_rate(results: Results, systems: Sequence[System], options: Options) -> None:
    """(d) The highest rate of LADDER at which one reader loses nothing, found by halving."""
    case = "(d) highest rate"

    async def measure(system: System) -> None:
        best, low, high = 0.0, 0, len(LADDER)
        while low < high:
            middle = (low + high) // 2
            rate = LADDER[middle]
            reading = await _without_loss(system, Goal(rate, int(rate * options.seconds), 0.5))
            if reading.lost:
                high = middle
                continue
            best, low = rate, middle + 1
            if reading.achieved_hz < 0.95 * rate:  # the action server is the limit
                best = reading.achieved_hz
                break
        if not best:
            raise Impossible(f"it lost {reading.lost} of {reading.expected} messages at {rate} Hz")
        results.add(case, "without loss, 1 reader", system.name, best, "Hz")

    await take_turns(results, case, systems, options, measure)


async def _without_loss(system: System, goal: Goal) -> Reading:
    """Read a goal's feedback, and once more if messages were lost: the machine may have been busy."""
    reading = await system.stream(goal, 1)
    return await system.stream(goal, 1) if reading.lost else reading
