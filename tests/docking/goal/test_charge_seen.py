"""A charge is what the battery's messages say, of a robot that stands on its dock."""

import math
from dataclasses import replace
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.battery import BatteryReading, PowerSupplyStatus
from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.charger_doubt import ChargerDoubt
from docking.goal.charging import ChargeRecord
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.objective import Progress
from docking.goal.outcome import Command, End, Outcome
from docking.nodes.dock_server import docking_objective
from docking.parameters import ControllerName, DockSettings, DockTimeouts
from docking.plans.registry import make_plan
from docking.simulation.battery import BatterySettings
from docking.simulation.dock import DOCKED
from docking.simulation.dock import DockSettings as DockOfSimulation
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
NEAR = Pose(-1.2, 0.1, 0.1)
CHARGING, IDLE = PowerSupplyStatus.CHARGING, PowerSupplyStatus.NOT_CHARGING
DOCK_POSE = DockSettings(controller=ControllerName.DOCK_POSE)


def hear(record: ChargeRecord, says: list[bool], period: float) -> list[bool]:
    """Whether the charge is stable after each message."""
    stable = []
    for number, charges in enumerate(says):
        record.hear(number * period, BatteryReading(1 if charges else 3, number * period), charges=charges)
        stable.append(record.is_stable)
    return stable


@pytest.mark.parametrize(("period", "messages"), [(0.1, 11), (0.5, 3), (0.6, 5), (1.0, 5), (5.0, 5)])
def test_enough_messages_say_so_for_long_enough(period: float, messages: int) -> None:
    assert hear(ChargeRecord(1.0), [True] * messages, period) == [False] * (messages - 1) + [True]


def test_one_that_says_otherwise_makes_it_begin_again_and_need_twice_as_many() -> None:
    stable = hear(ChargeRecord(1.0), [True] * 4 + [False] + [True] * 10, 1.0)
    assert stable == [False] * 14 + [True]


def test_the_same_message_counts_once() -> None:
    record = ChargeRecord(1.0)
    for _ in range(100):
        record.hear(5.0, BatteryReading(1, 5.0), charges=True)
    assert record.charges
    assert not record.is_stable


def test_where_it_need_not_last_one_message_is_enough() -> None:
    assert hear(ChargeRecord(0.0), [True, False], 1.0) == [True, False]


@given(st.lists(st.booleans(), max_size=30), st.floats(0.1, 5.0))
def test_no_charge_is_stable_that_was_not_seen_three_times_in_a_row(says: list[bool], period: float) -> None:
    stable = hear(ChargeRecord(1.0), says, period)
    for number, is_stable in enumerate(stable):
        assert not is_stable or says[max(0, number - 2) : number + 1] == [True] * 3


def dock(simulation: Simulation, settings: DockSettings = DOCK_POSE) -> tuple[Goal, Outcome]:
    goal = Goal(make_plan(settings), docking_objective(settings, DockMemory()), simulation.time)
    while isinstance(step := goal.step(simulation.observe()), Command):
        simulation.run(PERIOD, step.velocity)
        assert simulation.time < 600.0
    return goal, step


@pytest.mark.parametrize("rate", [0.2, 0.5, 1.0, 2.0])
def test_a_charge_that_flickers_is_none_however_rarely_the_battery_speaks(rate: float) -> None:
    settings = replace(DOCK_POSE, timeouts=DockTimeouts(max_retries=0))
    world = Settings(start=NEAR, battery=BatterySettings(battery_rate=rate), dock=DockOfSimulation(flickers=True))
    for seed in range(2):
        simulation = Simulation(world, seed)
        simulation.run(Random(seed).random() / rate)
        _, outcome = dock(simulation, settings)
        assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE


@pytest.mark.parametrize("rate", [0.2, 1.0])
def test_a_battery_that_speaks_rarely_is_believed_after_a_while(rate: float) -> None:
    simulation = Simulation(Settings(start=NEAR, battery=BatterySettings(battery_rate=rate)), 5)
    _, outcome = dock(simulation)
    assert outcome.end is End.SUCCEEDED
    assert simulation.charging


def says_charging_on_the_way(seed: int) -> tuple[Simulation, Outcome]:
    """From a random moment on, the battery says that it charges."""
    simulation, random = Simulation(Settings(start=NEAR), seed), Random(seed)
    goal = Goal(make_plan(DOCK_POSE), docking_objective(DOCK_POSE, DockMemory()), 0.0)
    begins, lasts = random.uniform(1.0, 6.0), random.choice((0.5, 3.0, 600.0))
    while True:
        observation = simulation.observe()
        if begins <= simulation.time < begins + lasts and observation.battery is not None:
            observation = replace(observation, battery=replace(observation.battery, status=CHARGING))
        step = goal.step(observation)
        if isinstance(step, Outcome):
            return simulation, step
        simulation.run(PERIOD, step.velocity)


@pytest.mark.parametrize("seed", range(6))
def test_a_robot_that_drives_is_on_no_charger(seed: int) -> None:
    simulation, outcome = says_charging_on_the_way(seed)
    if outcome.end is End.SUCCEEDED:
        assert simulation.robot.pose.distance_to(DOCKED) < 0.05
    else:
        assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
        assert "the battery said that it charges" in outcome.error_msg


def test_what_goes_along_or_is_elsewhere_is_doubted_and_what_stands_is_believed() -> None:
    doubt = ChargerDoubt()
    assert doubt.believes(Pose(), STANDSTILL, None, charges=True)
    assert not doubt.believes(Pose(), Velocity(0.1), None, charges=True)
    assert doubt.believes(Pose(0.09), STANDSTILL, None, charges=True)
    assert not doubt.believes(Pose(0.11), STANDSTILL, None, charges=True)
    assert not doubt.believes(Pose(0.05), STANDSTILL, None, charges=True)
    assert "while the robot moved by 0.1 m" in doubt.reason
    assert not doubt.believes(Pose(0.05), STANDSTILL, None, charges=False)
    assert doubt.believes(Pose(0.05), STANDSTILL, Pose(0.3), charges=True)
    assert not doubt.believes(Pose(0.05), STANDSTILL, Pose(0.4), charges=True)
    assert "0.4 m from the dock" in doubt.reason
    assert ChargerDoubt().believes(None, STANDSTILL, None, charges=True)


def test_who_drives_on_along_long_contacts_charges() -> None:
    doubt = ChargerDoubt()
    for centimetres in range(16):
        doubt.believes(Pose(0.01 * centimetres), Velocity(0.04), Pose(0.16), charges=True)
    assert doubt.believes(Pose(0.16), STANDSTILL, Pose(0.16), charges=True)
    assert doubt.reason == ""


def test_who_only_turns_believes_the_battery_as_the_tutorial_does() -> None:
    settings = DockSettings()
    goal = Goal(make_plan(settings), docking_objective(settings, DockMemory()), 0.0)
    assert goal.step(Observation(1.0, BatteryReading(IDLE, 1.0))).error_code is ErrorCode.NONE
    assert goal.step(Observation(2.0, BatteryReading(CHARGING, 2.0))) == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize(
    ("status", "percentage", "at", "docks"),
    [
        (IDLE, 1.0, Pose(1.0), True),
        (IDLE, 0.96, Pose(1.04), True),
        (IDLE, 0.94, Pose(1.0), False),
        (IDLE, 100.0, Pose(1.0), False),
        (IDLE, math.nan, Pose(1.0), False),
        (IDLE, 1.0, Pose(0.9), False),
        (PowerSupplyStatus.DISCHARGING, 1.0, Pose(1.0), False),
        (PowerSupplyStatus.FULL, 1.0, Pose(1.0), True),
    ],
)
def test_a_full_battery_is_docked_where_the_robot_is(
    status: PowerSupplyStatus, percentage: float, at: Pose, *, docks: bool
) -> None:
    docking, reached = Docking(DockTimeouts()), False
    for number in range(30):
        now = 0.1 * number
        battery = BatteryReading(status, now, percentage=percentage)
        observation = Observation(now, battery, Odometry(at, STANDSTILL, now))
        reached = docking.is_reached(observation, battery, Progress(True, False, Pose(1.0)))
    assert reached is docks
    assert (f"the battery is full ({100.0 * percentage:.0f} %)" in docking.doubt) is (docks and status == IDLE)


def test_the_outcome_tells_that_a_full_battery_does_not_charge() -> None:
    simulation = Simulation(Settings(start=NEAR, battery=BatterySettings(battery_start=1.0)), 5)
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    _, outcome = dock(simulation)
    assert outcome.end is End.SUCCEEDED
    assert any("the battery is full" in doubt for doubt in outcome.doubts)
