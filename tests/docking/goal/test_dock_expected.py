"""Where the dock is known before it is seen: which of two markers counts, and from where the robot looks."""

import math
from dataclasses import replace
from random import Random

import pytest
from benchmarks.docking.cases import CASES
from benchmarks.docking.trial import run_trial
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockSettings
from docking.parameters.search import SearchSettings
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
AHEAD = Pose(-1.6, 0.2, 0.0)
DOCKING = DockSettings(controller=ControllerName.DOCK_POSE)


def in_odom(simulation: Simulation, pose: Pose) -> Pose:
    """A pose of world."""
    return simulation.odometry.pose.compose(simulation.robot.pose.inverse()).compose(pose)


class Drive:
    """One docking goal.

    Attributes:
        notes: What was said of the detections.
        farthest: How far odometry says that the robot was from its start, in m.
        way: How far it drove forwards and backwards, in m.
    """

    def __init__(
        self, start: Pose, docking: DockSettings = DOCKING, *, known: bool = False, seed: int = 1, **marker: float
    ) -> None:
        self.simulation = Simulation(Settings(start=start, marker=MarkerSettings(**marker)), seed)
        self.memory = DockMemory()
        self.goal = Goal(make_plan(docking), Docking(docking.timeouts, self.memory), 0.0)
        self.notes: list[str] = []
        self.farthest = self.way = 0.0
        self._known = known

    def see(self) -> Observation:
        """What is known now."""
        simulation = self.simulation
        return replace(simulation.observe(), expected_dock=in_odom(simulation, DOCKED) if self._known else None)

    def run(self) -> Outcome:
        """Until the goal ends."""
        simulation, start = self.simulation, self.simulation.odometry.pose
        while simulation.time < 900.0:
            step = self.goal.step(self.see())
            if isinstance(step, Outcome):
                return step
            self._note(step)
            simulation.run(PERIOD, step.velocity)
            self.farthest = max(self.farthest, simulation.odometry.pose.distance_to(start))
        raise AssertionError(f"still at {simulation.robot.pose}")

    def _note(self, step: Command) -> None:
        self.way += abs(step.velocity.linear_x) * PERIOD
        if step.note and step.note not in self.notes:
            self.notes.append(step.note)


@pytest.mark.parametrize("second_y", [0.5, -0.5, 0.9, -0.8])
def test_of_two_markers_the_one_is_taken_where_the_database_has_the_dock(second_y: float) -> None:
    drive = Drive(AHEAD, known=True, second_y=second_y)
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert drive.simulation.contact
    assert drive.simulation.bumps == 0
    assert drive.notes[-1].startswith(f"another marker is detected {abs(second_y):.1f} m from that of the dock: ")
    assert drive.notes[-1].endswith(" detections were left out")


def test_of_two_markers_neither_is_taken_where_nothing_tells() -> None:
    drive = Drive(AHEAD, second_y=0.6)
    outcome = drive.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.FAILED_TO_DETECT_DOCK, 0)
    assert outcome.error_msg.startswith("two markers are detected, 0.6 m from each other, and nothing tells which one")
    assert drive.way == 0.0


def test_of_two_markers_the_one_is_taken_where_the_robot_docked_last() -> None:
    last = replace(DOCKING, last_docked=DOCKED.compose(Pose(0.1, -0.1)).relative_to(AHEAD))
    assert Drive(AHEAD, last, second_y=0.6).run() == Outcome(End.SUCCEEDED)


def test_it_is_remembered_where_the_robot_docked() -> None:
    drive = Drive(AHEAD)
    assert drive.run() == Outcome(End.SUCCEEDED)
    place = drive.memory.dockings[""].place
    assert place is not None
    assert place.distance_to(drive.simulation.odometry.pose) < 0.01


def test_the_first_marker_that_is_seen_is_followed_although_another_one_appears() -> None:
    drive = Drive(AHEAD, second_y=0.7)
    observe = drive.see

    def see() -> Observation:
        seen = observe()
        if drive.simulation.time > 1.5 or not seen.other_markers:
            return seen
        return replace(seen, marker=seen.other_markers[0], other_markers=())

    drive.see = see  # type: ignore[method-assign]
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert drive.simulation.contact
    assert drive.simulation.bumps == 0


@settings(max_examples=8, derandomize=True)
@given(st.floats(0.5, 1.5), st.sampled_from([-1.0, 1.0]), st.integers(0, 10**6))
def test_a_marker_that_is_not_the_docks_never_moves_the_robot(distance: float, side: float, seed: int) -> None:
    """Only the other one is in view, and the robot may only turn."""
    still = replace(DOCKING, search=SearchSettings(known_dock_radius=0.0, dock_pose_tolerance=0.4))
    drive = Drive(AHEAD, still, known=True, seed=seed, second_y=side * distance)
    observe = drive.see

    def see() -> Observation:
        seen = observe()
        markers = [one for one in (*seen.other_markers, seen.marker) if one is not None]
        docks = in_odom(drive.simulation, Pose())
        others = [one for one in markers if one.pose.distance_to(docks) > 0.3]
        return replace(seen, marker=others[0] if others else None, other_markers=())

    drive.see = see  # type: ignore[method-assign]
    outcome = drive.run()
    assert outcome.error_code is ErrorCode.FAILED_TO_DETECT_DOCK
    assert drive.way == 0.0
    assert "another marker is detected" in outcome.error_msg


@settings(max_examples=3, derandomize=True)
@given(st.floats(0.3, 2.6), st.integers(0, 10**6))
def test_a_search_never_leaves_its_radius(radius: float, seed: int) -> None:
    random = Random(seed)
    start = Pose(random.uniform(-9.0, -7.0), random.uniform(-1.0, 1.0), random.uniform(-3.0, 3.0))
    drive = Drive(start, replace(DOCKING, search=SearchSettings(search_radius=radius)), seed=seed)
    drive.simulation.set_fault(Fault.OCCLUDED_MARKER, True)
    outcome = drive.run()
    assert outcome.error_code is ErrorCode.FAILED_TO_DETECT_DOCK
    assert 0.1 < drive.farthest <= radius


def test_without_a_radius_it_only_turns() -> None:
    drive = Drive(Pose(-8.0, 0.0, 1.0))
    outcome = drive.run()
    assert outcome.error_code is ErrorCode.FAILED_TO_DETECT_DOCK
    assert "initial_perception_timeout" in outcome.error_msg
    assert drive.way == 0.0


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("controller", "name"),
    [
        (ControllerName.DOCK_POSE, "starts behind the dock, pose known"),
        (ControllerName.INFRARED, "starts behind the dock, pose known"),
        (ControllerName.DOCK_POSE, "starts 4.3 to 6 m away, pose known"),
        (ControllerName.DOCK_POSE, "starts 77° to 105° off the axis, pose known"),
        (ControllerName.DOCK_POSE, "camera sees 50° and 1.2 m, pose known"),
        (ControllerName.DOCK_POSE, "camera sees 50° and 1.2 m, search_radius 4 m"),
        (ControllerName.DOCK_POSE, "two tags on one topic, pose known"),
    ],
)
def test_it_docks_from_where_the_dock_is_not_in_view(controller: ControllerName, name: str, seed: int) -> None:
    case = next(case for case in CASES if case.name == name)
    trial = run_trial(controller, seed, case)
    assert trial.docked, trial.error_code
    assert trial.bumps == 0
    assert math.hypot(*trial.trail[-1]) < 0.25
