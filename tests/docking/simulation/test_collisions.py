from dataclasses import replace

import pytest

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.simulation.dock import DOCKED, DockSettings
from docking.simulation.faults import Fault
from docking.simulation.odometry import OdometrySettings
from docking.simulation.robot import RobotSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import STEP, Simulation

EXACT = Settings(start=Pose(-0.3), robot=RobotSettings(slip=0.0, slip_noise=0.0), odometry=OdometrySettings(drift=0.0))


def drive(simulation: Simulation, seconds: float, linear: float) -> None:
    for _ in range(round(seconds / 0.1)):
        simulation.run(0.1, Velocity(linear))


def test_each_contact_with_the_dock_is_recorded_with_its_speed() -> None:
    simulation = Simulation(EXACT)
    drive(simulation, 3.0, 0.05)
    assert [(touch.speed, touch.on_contacts) for touch in simulation.touches] == [(pytest.approx(0.05), True)]
    drive(simulation, 3.0, -0.05)
    drive(simulation, 2.0, 0.1)
    assert [touch.speed for touch in simulation.touches] == [pytest.approx(0.05), pytest.approx(0.1)]


def test_a_robot_that_presses_on_the_dock_touches_it_once() -> None:
    simulation = Simulation(EXACT)
    for _ in range(10):
        drive(simulation, 1.0, 0.04)
        drive(simulation, 0.2, -0.04)
    assert len(simulation.touches) == 1


def test_a_contact_beside_the_contacts_is_one_too() -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-0.3, 0.1)))
    drive(simulation, 3.0, 0.12)
    assert [(touch.speed, touch.on_contacts) for touch in simulation.touches] == [(pytest.approx(0.12), False)]
    assert simulation.bumps == 1


def test_a_robot_that_is_set_down_on_the_dock_touched_nothing() -> None:
    simulation = Simulation(replace(EXACT, start=DOCKED))
    simulation.run(1.0)
    simulation.place(Pose(-0.5))
    simulation.place(DOCKED)
    simulation.run(1.0)
    assert list(simulation.touches) == []


@pytest.mark.parametrize("by_fault", [True, False])
def test_contacts_that_flicker_charge_on_and_off_for_ever(by_fault: bool) -> None:
    simulation = Simulation(replace(EXACT, start=DOCKED, dock=DockSettings(flickers=not by_fault)))
    simulation.set_fault(Fault.FLICKERING_CHARGE, by_fault)
    charging = []
    for _ in range(round(60.0 / STEP)):
        simulation.step()
        charging.append(simulation.charging)
    runs = "".join("x" if on else " " for on in charging).split()
    assert 80 <= len(runs) <= 90
    assert max(map(len, runs)) * STEP <= 0.42
    simulation.set_fault(Fault.FLICKERING_CHARGE, False)
