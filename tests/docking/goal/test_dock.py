"""The objective of docking, by itself: time limits and defaults. `test_charging` has what charges."""

from dataclasses import replace

import pytest

from docking.core.battery import BatteryReading
from docking.core.errors import (
    DockingError,
    FailedToCharge,
    FailedToControl,
    FailedToDetectDock,
    FailedToStage,
    Stage,
)
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry
from docking.goal.dock import Docking
from docking.goal.objective import Deadline, Progress
from docking.parameters import ChargingSettings, ChargingSource, DockTimeouts

TIMEOUTS = DockTimeouts(
    initial_perception_timeout=1.0,
    staging_timeout=2.0,
    dock_approach_timeout=3.0,
    wait_charge_timeout=4.0,
    retry_timeout=5.0,
)


@pytest.mark.parametrize(
    ("stage", "parameter", "error", "message"),
    [
        (Stage.INITIAL_PERCEPTION, "initial_perception_timeout", FailedToDetectDock, "the dock was not found"),
        (Stage.NAV_TO_STAGING_POSE, "staging_timeout", FailedToStage, "the staging pose was not reached"),
        (Stage.CONTROLLING, "dock_approach_timeout", FailedToControl, "the dock was not reached"),
        (Stage.WAIT_FOR_CHARGE, "wait_charge_timeout", FailedToCharge, "the battery on the dock did not charge"),
        (Stage.RETRY, "retry_timeout", FailedToControl, "the robot did not back off"),
    ],
)
def test_each_stage_has_the_time_limit_of_its_parameter(
    stage: Stage, parameter: str, error: type[DockingError], message: str
) -> None:
    limit = Docking(TIMEOUTS).deadline(stage, False)
    assert limit == Deadline(parameter, getattr(TIMEOUTS, parameter), error, message)


def test_other_stages_have_none() -> None:
    assert Docking(TIMEOUTS).deadline(Stage.IDLE, False) is None


@pytest.mark.parametrize(("off", "reached"), [(0.05, True), (0.06, False)])
def test_by_its_pose_a_robot_is_docked_within_5_cm_unless_something_else_is_wanted(off: float, reached: bool) -> None:
    by_pose = ChargingSettings(charging_source=ChargingSource.POSE)
    objective = Docking(replace(TIMEOUTS, charge_stable_for=0.0), charging=by_pose)
    battery = BatteryReading(3, 0.0)
    seen = Observation(0.0, battery, Odometry(Pose(), STANDSTILL, 0.0))
    assert objective.is_reached(seen, battery, Progress(True, False, Pose(off))) is reached


def test_a_dock_without_a_type_is_remembered_as_that() -> None:
    objective = Docking(TIMEOUTS)
    objective.is_reached(Observation(0.0), None, Progress(False, False, None))
    assert objective.memory.dock_type == ""
