import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose, normalize_angle
from docking.parameters import Dock

POSES = st.builds(Pose, st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))


def test_the_robot_stands_before_the_marker_also_if_that_looks_out_of_the_dock() -> None:
    dock = Dock(external_detection_translation_x=-0.2, external_detection_rotation_yaw=math.pi)
    docked = dock.docked(Pose(2.0, 0.0, math.pi))
    assert (docked.x, docked.y) == pytest.approx((1.8, 0.0))
    assert normalize_angle(docked.theta) == pytest.approx(0.0)


@given(marker=POSES, docked=POSES)
def test_a_calibrated_dock_is_where_it_was_measured(marker: Pose, docked: Pose) -> None:
    offset = Dock.offset(docked.relative_to(marker))
    dock = Dock(
        external_detection_translation_x=offset.x,
        external_detection_translation_y=offset.y,
        external_detection_rotation_yaw=offset.theta,
    )
    again = dock.docked(marker)
    assert again.distance_to(docked) < 1e-9
    assert abs(normalize_angle(again.theta - docked.theta)) < 1e-9
