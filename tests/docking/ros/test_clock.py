"""What a goal says of a clock, and of a machine, that is too slow."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import pytest

from docking.ros.clock import ClockWatch


@dataclass
class Clocks:
    """The clock of a node, and real time, in seconds."""

    node_time: float = 1000.0
    real_time: float = 50.0
    simulated: bool = True

    def get_clock(self) -> Any:
        now = SimpleNamespace(nanoseconds=round(1e9 * self.node_time))
        return SimpleNamespace(ros_time_is_active=self.simulated, now=lambda: now)

    def step(self, watch: ClockWatch, *, real: float, simulated: float, times: int = 1) -> bool:
        for _ in range(times):
            self.real_time += real
            self.node_time += simulated
            stopped = watch.stopped
        return stopped


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    clocks = Clocks()
    monkeypatch.setattr("docking.ros.clock.time", SimpleNamespace(monotonic=lambda: clocks.real_time))
    return clocks


def watch_of(clocks: Clocks) -> ClockWatch:
    watch = ClockWatch(cast("Any", clocks))
    watch.begin()
    return watch


def test_a_machine_that_keeps_up_is_not_mentioned(clocks: Clocks) -> None:
    watch = watch_of(clocks)
    assert not clocks.step(watch, real=0.05, simulated=0.05, times=400)
    assert watch.doubt == ""


def test_a_clock_that_runs_slowly_is_named_with_its_rate(clocks: Clocks) -> None:
    watch = watch_of(clocks)
    clocks.step(watch, real=0.1, simulated=0.04, times=40)
    assert watch.doubt == ""
    clocks.step(watch, real=0.1, simulated=0.04, times=40)
    assert watch.doubt == "the simulated clock ran at 0.4 of real time, as on a machine that is too slow"
    watch.begin()
    assert watch.doubt == ""


def test_a_pause_is_not_slowness(clocks: Clocks) -> None:
    watch = watch_of(clocks)
    clocks.step(watch, real=0.05, simulated=0.05, times=200)
    assert clocks.step(watch, real=0.05, simulated=0.0, times=400)
    assert not clocks.step(watch, real=0.05, simulated=0.05, times=100)
    assert watch.doubt == ""


@pytest.mark.parametrize("simulated", [True, False])
def test_control_steps_that_come_late_are_named(clocks: Clocks, simulated: bool) -> None:
    clocks.simulated = simulated
    watch = watch_of(clocks)
    clocks.step(watch, real=0.05, simulated=0.05, times=20)
    clocks.step(watch, real=0.8, simulated=0.8)
    clocks.step(watch, real=0.05, simulated=0.05, times=20)
    assert watch.doubt == "the machine is too slow: control steps came up to 0.8 s apart"
