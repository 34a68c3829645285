"""Random faults of sensors from random moments on: no fast contact, no long way, and the error says why."""

import math
from dataclasses import dataclass, replace
from random import Random

import pytest

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

FASTEST = 0.045
"""In m/s, at the dock."""
LONGEST = 300.0
"""In s."""
MARKER_FAULTS = (
    Fault.FROZEN_CAMERA,
    Fault.EXTRAPOLATING_CAMERA,
    Fault.LAGGING_DETECTIONS,
    Fault.FROZEN_ODOMETRY,
    Fault.OPEN_LOOP_ODOMETRY,
)


@dataclass
class Run:
    """What became of one goal."""

    outcome: Outcome
    way: float
    fastest: float
    needed: float


def run(
    seed: int,
    fault: Fault | None,
    begins: float = 0.0,
    ends: float = math.inf,
    *,
    controller: ControllerName = ControllerName.DOCK_POSE,
    held: bool = False,
    watches: bool = False,
) -> Run:
    """Dock once from a random start, with a fault for a while; `held` holds the robot meanwhile."""
    random = Random(seed)
    distance = random.uniform(0.6, 2.0 if controller is ControllerName.DOCK_POSE else 1.0)
    start = Pose(-distance, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3))
    parameters = DockSettings(controller=controller)
    collision = replace(parameters.collision, use_collision_detection=watches)
    parameters = replace(parameters, collision=collision)
    simulation = Simulation(Settings(start=start), seed)
    simulation.scanning = watches
    goal = Goal(make_plan(parameters), Docking(parameters.timeouts), 0.0, watch_obstacles(parameters))
    step: Command | Outcome = goal.step(simulation.observe())
    way, last = 0.0, simulation.robot.pose
    while isinstance(step, Command) and simulation.time < LONGEST:
        active = begins <= simulation.time < ends
        if fault is not None:
            simulation.set_fault(fault, active)
        simulation.halted = held and active
        simulation.run(parameters.control_period, step.velocity)
        way, last = way + last.distance_to(simulation.robot.pose), simulation.robot.pose
        step = goal.step(simulation.observe())
    assert isinstance(step, Outcome), "every goal ends"
    return Run(step, way, max((touch.speed for touch in simulation.touches), default=0.0), distance)


@pytest.mark.parametrize("seed", range(10))
def test_whatever_lies_the_robot_neither_hits_the_dock_nor_drives_far(seed: int) -> None:
    random = Random(f"lies {seed}")
    fault = MARKER_FAULTS[seed % len(MARKER_FAULTS)]
    begins = random.choice((0.0, random.uniform(0.0, 15.0)))
    ends = random.choice((math.inf, begins + random.uniform(0.5, 6.0)))
    result = run(seed, fault, begins, ends, held=fault is Fault.OPEN_LOOP_ODOMETRY)
    assert result.fastest <= FASTEST, (fault, begins, ends)
    assert result.way <= 3.0 * result.needed + 2.0, (fault, begins, ends)


@pytest.mark.parametrize("begins", [0.0, 2.0, 3.0])
def test_a_frozen_camera_is_named(begins: float) -> None:
    result = run(3, Fault.FROZEN_CAMERA, begins)
    outcome = result.outcome
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.LOST_MARKER)
    assert "its detector repeats an image" in outcome.error_msg
    assert result.fastest == 0.0


def test_a_camera_that_recovers_is_believed_again() -> None:
    result = run(3, Fault.FROZEN_CAMERA, 4.0, 7.0)
    assert result.outcome.end is End.SUCCEEDED
    assert any("seen at one place" in doubt for doubt in result.outcome.doubts)


def test_detections_that_are_late_are_placed_where_they_were_made() -> None:
    result = run(5, Fault.LAGGING_DETECTIONS)
    assert result.outcome.end is End.SUCCEEDED
    assert result.outcome.doubts == ("detections are about 0.5 s older than their stamps",)


def test_without_a_fault_nothing_is_doubted() -> None:
    assert run(5, None).outcome == Outcome(End.SUCCEEDED)
    assert run(5, None).outcome.doubts == ()


def test_a_beacon_that_is_repeated_is_named() -> None:
    result = run(2, Fault.FROZEN_BEACON, 0.0, controller=ControllerName.INFRARED)
    assert result.outcome.end is End.ABORTED
    assert "repeated one reading" in result.outcome.error_msg
    assert result.way < 2.0


def test_a_scan_that_is_repeated_is_none() -> None:
    result = run(2, Fault.FROZEN_SCAN, 2.0, watches=True)
    assert (result.outcome.end, result.outcome.error_code) == (End.ABORTED, ErrorCode.SCAN_LOST)
    assert result.fastest == 0.0
