"""The record of what seemed wrong on the way of a goal."""

from dataclasses import replace

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL
from docking.goal.dock import Docking
from docking.goal.doubts import LONGEST, MOST, Doubts
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation


def test_without_a_doubt_an_error_is_as_it_was() -> None:
    assert Doubts().explain("no charge") == "no charge"
    assert Doubts().sentences() == ()


def test_a_state_is_named_once_with_its_last_sentence_and_an_event_with_its_number() -> None:
    doubts = Doubts()
    for left_out in range(5):
        doubts.note("other", f"{left_out} detections were left out")
    for left in (3, 2):
        doubts.count("hit", f"something was hit {left} cm before the dock")
    assert doubts.explain("no charge") == (
        "no charge. Noted on the way: 4 detections were left out; something was hit 2 cm before the dock (2 times)"
    )


def test_what_the_error_says_is_not_said_again() -> None:
    doubts = Doubts()
    doubts.count("charge", "no charge")
    assert doubts.explain("no charge; then, while backing off: stuck") == "no charge; then, while backing off: stuck"


def test_an_error_stays_short_however_much_was_noted() -> None:
    doubts = Doubts()
    for number in range(1000):
        doubts.note(f"kind {number}", f"{number}: {'so ' * 200}")
    sentences = doubts.sentences()
    assert len(sentences) == MOST + 1
    assert sentences[-1] == f"{1000 - MOST} more"
    assert len(doubts.explain("")) < (MOST + 1) * (LONGEST + 10) + 100


def test_a_goal_that_ends_without_a_charge_says_that_there_was_another_marker() -> None:
    start, marker = Pose(-1.0, 0.1), MarkerSettings(second_y=0.5)
    simulation = Simulation(Settings(start=start, marker=marker), 4)
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    parameters = DockSettings(controller=ControllerName.DOCK_POSE)
    goal = Goal(make_plan(parameters), Docking(replace(parameters.timeouts, max_retries=0)), simulation.time)
    step: Command | Outcome = Command(Stage.IDLE, STANDSTILL)
    while isinstance(step, Command) and simulation.time < 120.0:
        simulation.run(parameters.control_period, step.velocity)
        step = goal.step(replace(simulation.observe(), expected_dock=DOCKED.relative_to(start)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_CHARGE)
    assert "another marker is detected 0.5 m from that of the dock" in step.error_msg
    assert step.doubts[0].startswith("another marker is detected")
