"""The detector of the marker is switched on first: the robot waits for that, but not for ever."""

from dataclasses import dataclass, field

import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.observation import STANDSTILL
from docking.goal.detector import Detector
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, DockSettings
from docking.simulation.simulation import Simulation

NEVER = 1e9


@dataclass
class Service:
    """Is there after some calls, and answers after some more."""

    name: str = "/detector"
    found_after: float = 3
    answers_after: float = 3
    says: str = ""
    asked: list[bool] = field(default_factory=list)

    def switch_on(self) -> bool:
        self.asked.append(len(self.asked) >= self.found_after)
        return self.asked[-1]

    def answer(self) -> str | None:
        return self.says if sum(self.asked) > self.answers_after else None


def dock(service: Service) -> tuple[Outcome, list[Stage], float]:
    """One goal: how it ends, its stages, and when the robot began to move."""
    simulation, stages, moved_at = Simulation(seed=3), [], NEVER
    settings = DockSettings(controller=ControllerName.DOCK_POSE)
    goal = DockAction().make_goal(settings, DockMemory(), 0.0)
    goal.detect_with(Detector(service, 2.0))
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        stages.append(step.stage)
        if step.velocity != STANDSTILL:
            moved_at = min(moved_at, simulation.time)
        simulation.run(settings.control_period, step.velocity)
    return step, stages, moved_at


def test_the_robot_stands_until_the_detector_is_on() -> None:
    service = Service(answers_after=12)
    outcome, stages, moved_at = dock(service)
    assert outcome == Outcome(End.SUCCEEDED)
    assert stages[0] is Stage.INITIAL_PERCEPTION
    assert moved_at >= 15 * 0.05
    assert sum(service.asked) == 13, "it is asked no more once it is on"


@pytest.mark.parametrize(
    ("service", "sentence"),
    [
        (
            Service(found_after=NEVER),
            "the detector's service /detector was not there for 2 s (detector_service_timeout)",
        ),
        (
            Service(answers_after=NEVER),
            "the detector's service /detector did not answer for 2 s (detector_service_timeout)",
        ),
        (Service(says="no camera"), "the detector's service /detector did not switch it on: no camera"),
    ],
)
def test_a_detector_that_does_not_come_on_ends_the_goal(service: Service, sentence: str) -> None:
    outcome, _, moved_at = dock(service)
    assert (outcome.error_code, outcome.error_msg) == (ErrorCode.FAILED_TO_DETECT_DOCK, sentence)
    assert moved_at == NEVER
