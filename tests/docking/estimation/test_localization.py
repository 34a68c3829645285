import math

from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.estimation.localization import JUMP, PERSISTS, SteadyLocalization

KNOWN = Pose(1.0, 2.0, 0.3)
PERIOD = 0.1


def test_the_first_pose_is_believed() -> None:
    steady = SteadyLocalization()
    assert steady.believes(KNOWN, None, 0.0)
    assert not steady.jumped


def test_small_corrections_are_followed_at_once() -> None:
    steady = SteadyLocalization()
    assert steady.believes(Pose(1.0 + 0.9 * JUMP, 2.0, 0.3), KNOWN, 0.0)
    assert steady.largest == 0.0


@given(st.floats(0.05, 2.0), st.floats(-math.pi, math.pi), st.floats(0.1, PERSISTS - 0.2))
def test_a_jump_that_ends_is_never_believed(way: float, direction: float, lasts: float) -> None:
    steady = SteadyLocalization()
    away = Pose(KNOWN.x + way * math.cos(direction), KNOWN.y + way * math.sin(direction), KNOWN.theta)
    for step in range(round(lasts / PERIOD)):
        assert not steady.believes(away, KNOWN, step * PERIOD)
        assert steady.jumped
    assert steady.believes(KNOWN, KNOWN, lasts)
    assert not steady.jumped
    assert abs(steady.largest - way) < 1e-9, "it tells how far the localization may be off"


def test_a_jump_that_lasts_is_believed_and_only_then() -> None:
    steady, away = SteadyLocalization(), Pose(1.2, 2.0, 0.3)
    moments = [step * PERIOD for step in range(60)]
    believed = [now for now in moments if steady.believes(away, KNOWN, now)]
    assert believed[0] == min(now for now in moments if now >= PERSISTS)
    assert len(believed) == len([now for now in moments if now >= PERSISTS])


def test_poses_that_jump_about_are_not_believed_however_long() -> None:
    steady = SteadyLocalization()
    for step in range(300):
        away = Pose(1.0 + 0.1 * (1 + step // 20 % 3), 2.0, 0.3)
        assert not steady.believes(away, KNOWN, step * PERIOD)


def test_a_turn_is_a_jump_too() -> None:
    assert not SteadyLocalization().believes(Pose(1.0, 2.0, 0.3 + math.radians(5.0)), KNOWN, 0.0)
