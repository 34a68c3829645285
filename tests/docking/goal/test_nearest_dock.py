"""The nearest of several docks, by their poses and the robot's."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.errors import DockNotInDb
from docking.core.geometry import Pose
from docking.goal.nearest_dock import LONGEST, NearestDock
from docking.parameters import DockPlace

PLACES = st.lists(st.builds(Pose, st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=1, max_size=5)


@given(PLACES, st.builds(Pose, st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)))
def test_no_dock_is_nearer_than_the_nearest(poses: list[Pose], robot: Pose) -> None:
    places = [DockPlace(str(number), "map", pose) for number, pose in enumerate(poses)]
    found = NearestDock(places, 5.0).find(5.0, lambda frame: robot)
    assert found is not None
    assert found.pose.distance_to(robot) == min(pose.distance_to(robot) for pose in poses)


def robot_in(frame: str) -> Pose:
    """The robot is at the origin of the hall, and its place in the yard is not known."""
    if frame != "hall":
        raise ValueError(f"is given in the frame {frame!r}, which cannot be related")
    return Pose()


YARD, HALL = DockPlace("yard", "yard", Pose(0.1)), DockPlace("hall", "hall", Pose(5.0))


def test_a_dock_whose_frame_is_not_known_is_waited_for_and_then_left_out() -> None:
    nearest = NearestDock([YARD, HALL], 0.0)
    assert nearest.find(LONGEST - 0.1, robot_in) is None
    assert nearest.find(LONGEST - 0.1, lambda frame: Pose()) == YARD
    assert nearest.find(LONGEST, robot_in) == HALL


def test_where_nothing_tells_where_the_robot_is_the_reason_is_told() -> None:
    nearest = NearestDock([YARD], 0.0)
    assert nearest.find(0.0, robot_in) is None
    with pytest.raises(
        DockNotInDb, match="the nearest is not known: the pose of the dock 'yard' is given in the frame"
    ):
        nearest.find(LONGEST, robot_in)
