"""The simulator's own clock: late where the machine is, and never set forward while a goal may go by it."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosgraph_msgs.msg import Clock

from docking.parameters import DockSettings
from docking.ros.simulator_clock import IDLE_AFTER, SimulatorClock

PERIODS = st.lists(st.floats(0.001, 2.0), min_size=1, max_size=60)


class Driven:
    """A clock of a simulator that begins at 1000 s, and what it says."""

    def __init__(self) -> None:
        self.said: list[float] = []
        publisher = SimpleNamespace(publish=self._hear)
        node = SimpleNamespace(
            get_clock=lambda: SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=1000 * 10**9)),
            create_publisher=lambda *_, **__: publisher,
        )
        self.real = 0.0
        self.clock = SimulatorClock(cast("Any", node), self.real, publishes=True)

    def _hear(self, message: Clock) -> None:
        self.said.append(message.clock.sec + message.clock.nanosec / 1e9)

    @property
    def seconds(self) -> float:
        stamp = self.clock.stamp()
        return stamp.sec + stamp.nanosec / 1e9 - 1000.0

    def pass_by(self, period: float, *, driven: bool) -> float:
        self.real += period
        return self.clock.step(self.real, driven=driven)


def test_no_docking_server_waits_for_longer_without_a_command() -> None:
    timeouts = DockSettings().timeouts
    assert max(timeouts.initial_perception_timeout, timeouts.wait_charge_timeout) <= IDLE_AFTER


@given(PERIODS)
def test_while_a_goal_runs_only_what_is_simulated_passes(periods: list[float]) -> None:
    robot = Driven()
    simulated = robot.pass_by(0.03, driven=True)
    before = robot.seconds
    for period in periods:
        simulated = robot.pass_by(period, driven=False)  # such as while it waits for a charge
        assert robot.seconds == pytest.approx(before + simulated, abs=1e-6)
        before = robot.seconds


def test_once_nothing_drives_the_robot_it_is_real_time_again() -> None:
    robot = Driven()
    for _ in range(100):
        robot.pass_by(0.5, driven=True)
    assert robot.seconds < 10.0
    while robot.seconds < 10.0 + IDLE_AFTER:
        robot.pass_by(0.05, driven=False)
    robot.pass_by(0.05, driven=False)
    assert robot.seconds == pytest.approx(robot.real, abs=0.01)
    assert robot.said == sorted(robot.said)


def test_a_machine_that_is_too_slow_does_not_get_back_to_real_time_before_it_keeps_up() -> None:
    robot = Driven()
    for _ in range(100):
        robot.pass_by(0.5, driven=False)
    assert robot.real - robot.seconds > 40.0, "all but what it takes to notice it"
    for _ in range(100):
        robot.pass_by(0.05, driven=False)
    assert robot.seconds == pytest.approx(robot.real, abs=0.01)
