"""Docking although the robot is pushed aside close to its dock, or sees the dock no longer there."""

from dataclasses import replace

import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
STARTS = {ControllerName.DOCK_POSE: Pose(-1.3, 0.2, -0.1), ControllerName.INFRARED: Pose(-0.8, -0.2, 0.2)}


class Drive:
    """One docking goal.

    Attributes:
        codes: Why the robot tried again.
        backed: How far it drove backwards in the approaches, in m.
    """

    def __init__(self, controller: ControllerName, seed: int, *, push_at: float = 0.0, aside: float = 0.0) -> None:
        self.simulation = Simulation(Settings(start=STARTS[controller]), seed)
        docking = DockSettings(controller=controller)
        self.goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
        self.codes: set[ErrorCode] = set()
        self.backed = 0.0
        self._push_at, self._aside = push_at, aside

    def see(self, observation: Observation) -> Observation:
        return observation

    def run(self) -> Outcome:
        simulation = self.simulation
        while simulation.time < 300.0:
            step = self.goal.step(self.see(simulation.observe()))
            if isinstance(step, Outcome):
                return step
            self._note(step)
            if simulation.robot.pose.distance_to(DOCKED) < self._push_at:
                self._push_at = 0.0
                simulation.push(Pose(0.0, self._aside))
            simulation.run(PERIOD, step.velocity)
        raise AssertionError(f"still at {simulation.robot.pose}")

    def _note(self, step: Command) -> None:
        if step.stage is Stage.RETRY:
            self.codes.add(step.error_code)
        elif step.stage is Stage.CONTROLLING:
            self.backed += max(0.0, -step.velocity.linear_x) * PERIOD


@pytest.mark.parametrize("aside", [0.1, -0.1])
@pytest.mark.parametrize("distance", [0.04, 0.12, 0.2])
@pytest.mark.parametrize("controller", list(STARTS))
def test_a_robot_that_is_pushed_close_to_its_dock_backs_out_before_it_touches_it(
    controller: ControllerName, distance: float, aside: float
) -> None:
    drive = Drive(controller, round(100.0 * distance), push_at=distance, aside=aside)
    outcome = drive.run()
    assert (outcome.end, outcome.retries) == (End.SUCCEEDED, 1)
    assert drive.codes <= {ErrorCode.FAILED_TO_CONTROL, ErrorCode.LOST_MARKER, ErrorCode.INFRARED_LOST}
    assert drive.simulation.bumps == 0
    assert drive.simulation.contact


def test_an_error_that_can_be_made_good_is_made_good() -> None:
    drive = Drive(ControllerName.DOCK_POSE, 1, push_at=0.4, aside=0.03)
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert drive.simulation.bumps == 0


class ShortSighted(Drive):
    """A camera that does not see the marker from nearby."""

    nearest = 0.0

    def see(self, observation: Observation) -> Observation:
        near = self.simulation.robot.pose.distance_to(DOCKED) < self.nearest
        self._seen = getattr(self, "_seen", None) if near else observation.marker
        return replace(observation, marker=self._seen)


@pytest.mark.parametrize("nearest", [0.06, 0.1, 0.14])
def test_a_camera_that_does_not_see_the_marker_from_nearby_docks_without_a_retry(nearest: float) -> None:
    """The robot backs once, to where it sees the marker, to make sure that the dock is where it was."""
    drive = ShortSighted(ControllerName.DOCK_POSE, 2)
    drive.nearest = nearest
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert 0.0 < drive.backed < nearest + 0.02
    assert drive.simulation.bumps == 0
