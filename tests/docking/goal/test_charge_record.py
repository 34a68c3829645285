import math

import pytest
from benchmarks.docking.trial import settings_of, simulation_of

from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode
from docking.goal.charge_record import ChargeRecord
from docking.goal.dock import Docking
from docking.goal.engine import Command, Goal
from docking.parameters import ControllerName, DockTimeouts
from docking.plans.registry import make_plan
from docking.simulation.faults import Fault


def hear(record: ChargeRecord, charges: list[bool], current: float = 2.0, period: float = 0.5) -> None:
    for number, on in enumerate(charges):
        now = number * period
        record.hear(now, BatteryReading(1 if on else 3, now, current=current if on else -0.3), charges=on)


def test_no_charge_and_one_that_goes_on_are_no_story() -> None:
    for charges in ([False] * 4, [False, True, True, True]):
        record = ChargeRecord(1.0)
        hear(record, charges)
        assert (record.breaks, record.flickers, record.describe()) == (0, False, "")


def test_a_charge_that_broke_off_once_does_not_flicker() -> None:
    record = ChargeRecord(1.0)
    hear(record, [False, True, False, False])
    assert not record.flickers
    assert record.describe().startswith("the charge broke off once, after 0.5 s at most (charge_stable_for is 1 s)")


def test_it_tells_how_often_in_what_time_and_with_what_current() -> None:
    record = ChargeRecord(1.0)
    hear(record, [False, True, False] * 4)
    assert record.flickers
    assert record.describe().startswith(
        "the charge flickered: it broke off 4 times within 5.0 s, after 0.5 s at most (charge_stable_for is 1 s); the"
        " status is now 3 (NOT_CHARGING), the current -0.3 A, and up to 2 A while it charged"
    )


def test_a_current_that_is_not_measured_is_not_told() -> None:
    record = ChargeRecord(1.0)
    hear(record, [True, False] * 3, current=math.nan)
    assert "while it charged" not in record.describe()


@pytest.mark.parametrize("controller", [ControllerName.DOCK_POSE, ControllerName.INFRARED])
def test_a_goal_that_fails_for_it_says_so_in_time(controller: ControllerName) -> None:
    simulation, docking = simulation_of(controller, 3), settings_of(controller)
    simulation.set_fault(Fault.FLICKERING_CHARGE, True)
    goal = Goal(make_plan(docking), Docking(DockTimeouts(max_retries=0)), 0.0)
    step = goal.step(simulation.observe())
    while isinstance(step, Command):
        simulation.run(docking.control_period, step.velocity)
        step = goal.step(simulation.observe())
    assert step.error_code is ErrorCode.FAILED_TO_CHARGE
    assert step.error_msg.startswith(
        "the charge did not become stable within 5 s (wait_charge_timeout): the charge flick"
    )
    assert simulation.time - simulation.touches[0].time < 10.0
