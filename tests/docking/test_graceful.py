"""nav2's graceful law, with which `make bench-docking` compares ours, and the table of that."""

import math
from pathlib import Path

import pytest
from benchmarks.docking.comparison import COMPARISON, FAULTS, LAWS
from benchmarks.docking.graceful import GracefulLaw
from benchmarks.docking.page import empty_part, rows_in
from benchmarks.docking.trial import run_trial
from hypothesis import given
from hypothesis import strategies as st

from docking.behaviors.moves import steer
from docking.core.geometry import Pose, normalize_angle
from docking.parameters import ControllerName, Gains

LAW, STEP = GracefulLaw(), 0.02
ANGLES = st.floats(-math.pi, math.pi)
STARTS = st.builds(
    lambda distance, angle, heading: Pose(-distance * math.cos(angle), distance * math.sin(angle), heading),
    st.floats(0.5, 2.5),
    st.floats(-math.radians(60.0), math.radians(60.0)),
    ANGLES,
)


@given(STARTS, st.booleans())
def test_it_comes_to_its_target_and_keeps_its_limits(start: Pose, backward: bool) -> None:
    robot = start.compose(Pose(theta=math.pi)) if backward else start
    target = Pose(theta=math.pi) if backward else Pose()
    for _ in range(3000):
        if robot.distance_to(target) < 0.05:
            break
        velocity = LAW.velocity(robot, target, backward=backward)
        assert abs(velocity.linear_x) <= LAW.v_linear_max
        assert abs(velocity.angular_z) <= LAW.v_angular_max + 1e-9
        way, turn = velocity.linear_x * STEP, velocity.angular_z * STEP
        robot = robot.compose(Pose(way * math.cos(0.5 * turn), way * math.sin(0.5 * turn), turn))
    off = robot.relative_to(target)
    assert math.hypot(off.x, off.y) < 0.05
    assert abs(off.y) < 0.01
    assert abs(normalize_angle(off.theta)) < math.radians(10.0)


@given(STARTS)
def test_it_is_the_law_that_we_follow_too(start: Pose) -> None:
    assert LAW.curvature(start, Pose()) == pytest.approx(steer(start, Pose(), Gains()).curvature, abs=1e-6)


def test_nothing_slows_it_before_the_contacts() -> None:
    trial = run_trial(ControllerName.DOCK_POSE, 500000, law=LAW)
    assert trial.docked
    assert trial.retries == 0
    assert max(trial.contacts) > 0.2


def test_a_row_has_the_figures_of_both_laws(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(empty_part(COMPARISON.name))
    assert "contacts bounce for 1 s" in FAULTS
    COMPARISON.measure("contacts bounce for 1 s", range(1), 1, page)
    rows = rows_in(COMPARISON.measure("without velocity", range(1), 1, page))
    names = ("odometry without velocity", "contacts bounce for 1 s")
    assert [(key, row["docked"]) for key, row in rows.items()] == [
        ((name, law), "100 %") for name in names for law in LAWS
    ]
