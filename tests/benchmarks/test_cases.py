"""Systems take turns, and one that delivers nothing is left out instead of being shown as losing."""

from pathlib import Path

import pytest
from benchmarks.cases import FAN_OUT, fan_out, highest_rate, latency
from benchmarks.figures import Results
from benchmarks.options import Options
from benchmarks.site import Goal
from benchmarks.systems.base import Impossible, Reading, System, Timing

OPTIONS = Options(
    cases="b",
    rounds=3,
    goals=30,
    seconds=0.1,
    quiet=0.0,
    payload=0,
    robots=1,
    peers=None,
    variants=(),
    tokens=False,
    output=Path(),
)


class Scripted(System):
    """Delivers without loss up to a rate; above it, or where `delivers` is false, it loses."""

    def __init__(self, name: str, log: list[str], *, limit: float = 1e9, delivers: bool = True) -> None:
        self.name = name
        self._log = log
        self._limit = limit
        self._delivers = delivers

    async def start(self) -> None:
        """Nothing to start."""

    async def submit(self) -> Timing:
        """Instantly."""
        return Timing(1.0, 2.0)

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """All messages, all but one, or none."""
        self._log.append(f"{self.name} {goal.rate:g}")
        expected = goal.count * readers
        if not self._delivers:
            return Reading(expected, 0)
        lost = 1 if goal.rate > self._limit else 0
        return Reading(expected, expected - lost, [1.0] * expected, 0.999 * goal.rate)  # a clock is never exact


@pytest.fixture(autouse=True)
def _quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.cases.wait_until_quiet", lambda _bound: 0.0)
    monkeypatch.setattr("gc.collect", lambda: 0)  # slow with all that a test run holds


async def test_systems_take_turns() -> None:
    log: list[str] = []
    results = Results()
    await latency(results, [Scripted("A", log), Scripted("B", log)], OPTIONS)
    assert log[:6] == ["A 10", "B 10"] * 3
    figure = results.find("(b) 10 Hz", "p50", "A")
    assert figure is not None
    assert figure.turns == [1.0] * 3


async def test_system_that_delivers_nothing_is_left_out() -> None:
    results = Results()
    await latency(results, [Scripted("A", []), Scripted("mute", [], delivers=False)], OPTIONS)
    assert results.systems() == ["A"]
    assert set(results.left_out["mute", "(b) 100 Hz"]) == {"it delivered none of 10 messages"}


async def test_system_that_fails_in_one_turn_keeps_the_others() -> None:
    class Failing(Scripted):
        async def stream(self, goal: Goal, readers: int) -> Reading:
            if len(self._log) == 1:
                self._log.append("failed")
                raise Impossible("connection refused")
            return await super().stream(goal, readers)

    results = Results()
    await latency(results, [Failing("A", [])], OPTIONS)
    figure = results.find("(b) 10 Hz", "p50", "A")
    assert figure is not None
    assert len(figure.turns) == 2
    assert results.left_out == {("A", "(b) 10 Hz"): ["connection refused"]}


async def test_system_with_one_reader_has_no_fan_out() -> None:
    log: list[str] = []
    system = Scripted("A", log)
    system.max_readers = 1
    results = Results()
    await fan_out(results, [system], OPTIONS)
    assert log == ["A 20"] * 3
    assert len(results.left_out) == len(FAN_OUT) - 1


@pytest.mark.parametrize(("limit", "found"), [(500, 500), (1999, 1500), (2000, 2000), (5000, 5000), (1e9, 5000)])
async def test_highest_rate_is_found(limit: float, found: float) -> None:
    results = Results()
    await highest_rate(results, [Scripted("A", [], limit=limit)], OPTIONS)
    figure = results.find("(d) highest rate", "without loss, 1 reader", "A")
    assert figure is not None
    assert figure.turns == [found] * 3


async def test_highest_rate_below_the_ladder_has_a_reason() -> None:
    results = Results()
    await highest_rate(results, [Scripted("A", [], limit=100)], OPTIONS)
    assert results.left_out["A", "(d) highest rate"][0] == "it lost 1 of 50 messages at 500 Hz"
