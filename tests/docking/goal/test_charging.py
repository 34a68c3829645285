"""What tells that the battery charges: by itself, and in the simulation."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.goal.charging import ChargeRecord, stands_docked, tells_charging
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import End, Outcome
from docking.goal.undock import Undocking
from docking.nodes.dock_server import docking_objective
from docking.parameters import (
    ChargingSettings,
    ChargingSource,
    ControllerName,
    DockSettings,
    DockTimeouts,
    MotionLimits,
    RecoverySettings,
    UndockTimeouts,
)
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.battery import BatterySettings
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.odometry import OdometrySettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
NEAR = Pose(-1.2, 0.1, 0.1)
STATUS = ChargingSettings()
CURRENT = ChargingSettings(charging_source=ChargingSource.CURRENT)
NEGATIVE = replace(CURRENT, charging_current_negative=True)
POSE = ChargingSettings(charging_source=ChargingSource.POSE)
SILENT = BatterySettings(battery_reports_status=False)
REVERSED = replace(SILENT, battery_charges_negative=True)
EVERYTHING = st.floats()


@given(EVERYTHING, st.integers(0, 4))
def test_by_its_status_the_current_does_not_count(current: float, status: int) -> None:
    assert tells_charging(BatteryReading(status, 0.0, current=current), STATUS) == (status in {1, 4})


@given(EVERYTHING, st.integers(0, 4))
def test_by_its_current_the_status_does_not_count(current: float, status: int) -> None:
    battery = BatteryReading(status, 0.0, current=current)
    assert tells_charging(battery, CURRENT) == (0.5 < current <= 1000.0)
    assert tells_charging(battery, NEGATIVE) == (-1000.0 <= current < -0.5)
    assert not tells_charging(battery, POSE)


@pytest.mark.parametrize("velocity", [Velocity(0.1, 0.0), Velocity(-0.1, 0.0), Velocity(0.0, -0.2)])
def test_the_current_of_motors_charges_nothing(velocity: Velocity) -> None:
    battery = BatteryReading(0, 0.0, current=2.0)
    assert tells_charging(battery, CURRENT, Velocity(0.04, 0.0))
    assert not tells_charging(battery, CURRENT, velocity)
    assert tells_charging(replace(battery, status=1), STATUS, velocity)


def test_a_current_that_is_not_measured_charges_nothing() -> None:
    assert not tells_charging(BatteryReading(1, 0.0, current=math.nan), CURRENT)


@pytest.mark.parametrize(
    ("robot", "docked", "settings", "stands"),
    [
        (Pose(1.04, 0.0, 0.3), Pose(1.0), POSE, True),
        (Pose(1.06, 0.0), Pose(1.0), POSE, False),
        (None, Pose(1.0), POSE, False),
        (Pose(1.0), None, POSE, False),
        (Pose(1.0), Pose(1.0), STATUS, False),
        (Pose(1.0), Pose(1.0), CURRENT, False),
    ],
)
def test_by_the_pose(robot: Pose | None, docked: Pose | None, settings: ChargingSettings, stands: bool) -> None:
    assert stands_docked(robot, docked, settings, 0.05) == stands


def test_who_only_turns_knows_no_docked_pose() -> None:
    assert "rotate knows no docked pose" in (DockSettings(charging=POSE).find_conflict() or "")
    assert DockSettings(charging=POSE, controller=ControllerName.DOCK_POSE).find_conflict() is None


def run(simulation: Simulation, goal: Goal) -> Outcome:
    while simulation.time < 300.0:
        step = goal.step(simulation.observe())
        if isinstance(step, Outcome):
            return step
        simulation.run(PERIOD, step.velocity)
    raise AssertionError("no end")


def dock(
    simulation: Simulation,
    charging: ChargingSettings,
    memory: DockMemory | None = None,
    controller: ControllerName = ControllerName.DOCK_POSE,
) -> Outcome:
    stays = RecoverySettings(return_to_staging=False, max_corrections=0)
    settings = DockSettings(
        controller=controller, charging=charging, timeouts=DockTimeouts(max_retries=0), recovery=stays
    )
    return run(
        simulation, Goal(make_plan(settings), docking_objective(settings, memory or DockMemory()), simulation.time)
    )


def undock(simulation: Simulation, charging: ChargingSettings, memory: DockMemory | None = None) -> Outcome:
    objective = Undocking(UndockTimeouts(), memory, charging=charging)
    return run(simulation, Goal(UndockPlan(0.7, MotionLimits()), objective, simulation.time))


@pytest.mark.parametrize(
    ("battery", "charging", "controller"),
    [
        (SILENT, CURRENT, ControllerName.DOCK_POSE),
        (SILENT, POSE, ControllerName.DOCK_POSE),
        (REVERSED, NEGATIVE, ControllerName.DOCK_POSE),
        (SILENT, POSE, ControllerName.INFRARED),
    ],
)
def test_a_base_that_never_sets_the_status_docks_and_undocks(
    battery: BatterySettings, charging: ChargingSettings, controller: ControllerName
) -> None:
    start = NEAR if controller is ControllerName.DOCK_POSE else Pose(-0.8, -0.2, 0.2)
    simulation, memory = Simulation(Settings(start=start, battery=battery), seed=5), DockMemory()
    assert dock(simulation, charging, memory, controller).end is End.SUCCEEDED
    assert simulation.robot.pose.distance_to(DOCKED) < 0.03
    assert simulation.battery.current > 0.0
    assert simulation.bumps == 0
    simulation.run(1.0, STANDSTILL)
    where = simulation.robot.pose
    assert dock(simulation, charging, memory, controller).end is End.SUCCEEDED  # it is docked, and stays where it is
    assert simulation.robot.pose.distance_to(where) < 0.001
    assert undock(simulation, charging, memory).end is End.SUCCEEDED
    assert simulation.robot.pose.distance_to(DOCKED) > 0.6


@pytest.mark.parametrize(
    ("battery", "charging", "hint"),
    [
        (SILENT, STATUS, ": its status is 0 (UNKNOWN); charging_source may be current or pose"),
        (REVERSED, CURRENT, ""),
        (SILENT, NEGATIVE, ""),
    ],
)
def test_who_asks_the_wrong_source_does_not_dock(
    battery: BatterySettings, charging: ChargingSettings, hint: str
) -> None:
    outcome = dock(Simulation(Settings(start=NEAR, battery=battery), seed=5), charging)
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert outcome.error_msg == f"the battery on the dock did not charge within 5 s (wait_charge_timeout){hint}"


@pytest.mark.parametrize(
    ("battery", "code"), [(SILENT, ErrorCode.NONE), (REVERSED, ErrorCode.FAILED_TO_CHARGE)], ids=["right", "wrong"]
)
def test_poses_tell_whose_current_it_is_where_odometry_has_no_velocity(
    battery: BatterySettings, code: ErrorCode
) -> None:
    simulation = Simulation(Settings(start=NEAR, battery=battery, odometry=OdometrySettings(twist=False)), seed=5)
    assert dock(simulation, CURRENT).error_code is code
    assert simulation.robot.pose.distance_to(DOCKED) < 0.03


@pytest.mark.parametrize("back", [0.05, 0.7])
def test_a_robot_that_comes_by_the_place_where_it_was_docked_is_not_docked(back: float) -> None:
    simulation = Simulation(Settings(start=NEAR, battery=SILENT), seed=5)
    memory = DockMemory(True, DOCKED.compose(Pose(-back)).relative_to(NEAR))  # odometry has drifted since
    assert dock(simulation, POSE, memory).end is End.SUCCEEDED
    assert simulation.robot.pose.distance_to(DOCKED) < 0.03


@pytest.mark.parametrize(("charging", "code"), [(CURRENT, ErrorCode.FAILED_TO_CHARGE), (POSE, ErrorCode.NONE)])
def test_the_pose_says_nothing_of_a_charger_that_is_dead(charging: ChargingSettings, code: ErrorCode) -> None:
    simulation = Simulation(Settings(start=NEAR), seed=5)
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    assert dock(simulation, charging).error_code is code


def test_the_robot_stands_for_a_while_before_the_pose_counts() -> None:
    simulation = Simulation(Settings(start=NEAR, battery=SILENT), seed=5)
    settings = DockSettings(controller=ControllerName.DOCK_POSE, charging=POSE)
    goal = Goal(make_plan(settings), docking_objective(settings, DockMemory()), 0.0)
    stood = 0.0
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        stood = stood + PERIOD if step.velocity == STANDSTILL else 0.0
        simulation.run(PERIOD, step.velocity)
    assert step.end is End.SUCCEEDED
    assert stood >= settings.timeouts.charge_stable_for


@pytest.mark.parametrize(("battery", "charging"), [(SILENT, CURRENT), (REVERSED, NEGATIVE)])
def test_a_current_tells_that_the_robot_is_docked(battery: BatterySettings, charging: ChargingSettings) -> None:
    simulation = Simulation(Settings(start=DOCKED, battery=battery), seed=5)
    simulation.run(0.5)
    assert undock(simulation, charging).end is End.SUCCEEDED
    assert simulation.robot.pose.distance_to(DOCKED) > 0.6


@pytest.mark.parametrize(
    ("charging", "telling"),
    [(STATUS, "its battery is 0 (UNKNOWN)"), (NEGATIVE, "its current is 6.5 A"), (POSE, "its battery is 0 (UNKNOWN)")],
)
def test_undocking_moves_nothing_where_nothing_tells(charging: ChargingSettings, telling: str) -> None:
    simulation = Simulation(Settings(start=DOCKED, battery=SILENT), seed=5)
    simulation.run(0.5)
    outcome = undock(simulation, charging)
    assert outcome.error_code is ErrorCode.DOCKED_UNKNOWN
    assert telling in outcome.error_msg
    assert simulation.robot.pose.distance_to(DOCKED) < 0.001


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
    start = NEAR if controller is ControllerName.DOCK_POSE else Pose(-0.8, -0.2, 0.2)
    simulation = Simulation(Settings(start=start), seed=5)
    simulation.set_fault(Fault.FLICKERING_CHARGE, True)
    outcome = dock(simulation, STATUS, controller=controller)
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert outcome.error_msg.startswith(
        "the charge did not become stable within 5 s (wait_charge_timeout): the charge flick"
    )
    assert simulation.time - simulation.touches[0].time < 10.0
