"""Cases (a) to (d): acceptance, latency, fan-out, highest rate. Systems take turns, round by round."""

import asyncio
import gc
from collections import defaultdict
from collections.abc import Sequence

from benchmarks.figures import Results
from benchmarks.machine import wait_until_quiet
from benchmarks.options import Options
from benchmarks.site import Goal
from benchmarks.systems.base import Impossible, Reading, System, Timing

PAUSE = 0.05  # between goals: an action server that remembers many is slower for everyone
LATENCY_RATES = (10, 100, 1000)
FAN_OUT = ((1, 20), (200, 20), (1000, 20), (200, 100))
LADDER = (500, 750, 1000, 1500, 2000, 2500, 3000, 4000, 5000)


async def acceptance(results: Results, systems: Sequence[System], options: Options) -> None:
    """(a) Submit → accepted, and goal → result."""
    timings: dict[str, list[Timing]] = defaultdict(list)
    each = max(10, options.goals // options.rounds)
    for round_ in range(options.rounds):
        wait_until_quiet(options.quiet)
        for system in _turn(systems, round_):
            try:
                for _ in range(5):
                    await system.submit()
                for _ in range(each):
                    await asyncio.sleep(PAUSE)
                    timings[system.name].append(await system.submit())
            except (Impossible, OSError, TimeoutError, AssertionError) as error:
                results.missing("(a) goal", "", system.name, _why(error))
    for system in systems:
        accepted = [timing.accepted for timing in timings[system.name] if timing.accepted is not None]
        result = [timing.result for timing in timings[system.name] if timing.result is not None]
        if accepted:
            results.latencies("(a) goal", "submit → accepted", system.name, accepted)
        if result:
            results.latencies("(a) goal", "goal → result", system.name, result)


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
    readings: dict[str, list[Reading]] = defaultdict(list)
    impossible: set[str] = set()
    for round_ in range(options.rounds):
        for system in _turn(systems, round_):
            if system.name in impossible:
                continue
            wait_until_quiet(options.quiet)
            try:
                readings[system.name].append(await _read(system, goal, readers))
            except (Impossible, OSError, TimeoutError, AssertionError) as error:
                results.missing(case, "", system.name, _why(error))
                impossible.add(system.name)
    for system in systems:
        if found := readings[system.name]:
            add_readings(results, case, system.name, found)


def add_readings(results: Results, case: str, system: str, readings: Sequence[Reading]) -> None:
    """Add what some runs of one system gave."""
    results.latencies(case, "", system, (value for reading in readings for value in reading.latencies))
    results.add(case, "CPU", system, sorted(reading.cpu for reading in readings)[len(readings) // 2], unit="%")
    lost, expected = sum(reading.lost for reading in readings), sum(reading.expected for reading in readings)
    results.add(case, "lost", system, lost, unit="lost", note=f"{lost} of {expected} messages lost" if lost else "")


async def highest_rate(results: Results, systems: Sequence[System], options: Options) -> None:
    """(d) The highest rate at which one reader loses nothing, twice tried."""
    case, measure = "(d) highest rate", "without loss, 1 reader"
    best: dict[str, float] = {}
    climbing = list(systems)
    for rate in LADDER:
        for system in list(climbing):
            try:
                for _ in range(2):
                    wait_until_quiet(options.quiet)
                    reading = await _read(system, Goal(rate, int(rate * options.seconds), 0.5), 1)
                    if not reading.lost:
                        break
            except (Impossible, OSError, TimeoutError, AssertionError) as error:
                results.missing(case, "", system.name, _why(error))
                climbing.remove(system)
                continue
            if reading.lost:
                climbing.remove(system)
                results.missing(case, "", system.name, f"at {rate} Hz {reading.lost} of {reading.expected} were lost")
                continue
            best[system.name] = rate
            if reading.achieved_hz < 0.95 * rate:
                results.missing(case, "", system.name, f"the action server itself reached {reading.achieved_hz:.0f} Hz")
                best[system.name] = reading.achieved_hz
                climbing.remove(system)
    for name, rate in best.items():
        results.add(case, measure, name, rate, unit="Hz")


async def _read(system: System, goal: Goal, readers: int) -> Reading:
    gc.collect()
    gc.disable()  # the load client's own pauses are nobody's latency
    try:
        return await system.stream(goal, readers)
    finally:
        gc.enable()


def _turn(systems: Sequence[System], round_: int) -> list[System]:
    first = round_ % len(systems)
    return [*systems[first:], *systems[:first]]


def _why(error: Exception) -> str:
    return str(error)[:200] or type(error).__name__
