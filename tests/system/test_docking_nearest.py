"""A goal for the nearest dock, with the programs that users start: the robot docks at the one that it is nearest to."""

from pathlib import Path

import pytest
from geometry_msgs.msg import Twist

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED
from tests.support.docking import ABORTED, FAST, SUCCEEDED, UNMEASURED, Reports, send_dock_goal
from tests.support.observer import Observer
from tests.support.processes import Process, ros_environment
from tests.support.site import look_at

pytestmark = pytest.mark.ros

LEFT = 2.0
DOCKS = f"""
docks:
  right: {{frame: map, pose: [{DOCKED.x}, 0, 0]}}
  left: {{frame: map, pose: [{DOCKED.x}, {LEFT}, 0]}}
  somewhere: {{}}
"""


@pytest.mark.parametrize(("start", "dock"), [(Pose(-1.4, 1.3, 0.3), LEFT), (Pose(-1.4, 0.7, -0.3), 0.0)])
def test_the_robot_docks_at_the_dock_that_it_is_nearest_to(
    domain: int, observer: Observer, tmp_path: Path, start: Pose, dock: float
) -> None:
    docks = tmp_path / "docks.yaml"
    docks.write_text(DOCKS)
    world = (FAST, f"docks:=[{LEFT}]", f"start_x:={start.x}", f"start_y:={start.y}", f"start_theta:={start.theta}")
    server = ("controller:=dock_pose", "odometry_timeout:=10.0", UNMEASURED, f"dock_database:={docks}")
    env = ros_environment(domain)
    with Process("dock_simulator", *given(world), env=env), Process("docking_server", *given(server), env=env):
        here = look_at(observer)
        goal = send_dock_goal(observer, dock="nearest")
        assert goal.accepted
        assert goal.result(90.0).status == SUCCEEDED
        assert Pose(DOCKED.x, dock).distance_to(here.pose) < 0.03


def given(parameters: tuple[str, ...]) -> list[str]:
    return ["--ros-args", *(text for parameter in parameters for text in ("-p", parameter))]


def test_without_a_localization_the_goal_ends_with_the_reason_and_the_robot_stands(
    domain: int, observer: Observer, tmp_path: Path
) -> None:
    docks = tmp_path / "docks.yaml"
    docks.write_text(DOCKS)
    server = ("controller:=dock_pose", "odometry_timeout:=10.0", f"dock_database:={docks}")
    env = ros_environment(domain)
    with (
        Process("dock_simulator", *given(("publish_map:=false", "room:=false")), env=env),
        Process("docking_server", *given((*server, "frame_prefix:=other/")), env=env),
    ):
        here, reports = look_at(observer), Reports(observer)
        goal = send_dock_goal(observer, dock="nearest")
        assert goal.result(20.0).status == ABORTED
        report = reports.wait_for(goal_id=goal.goal_id, error_code="DOCK_NOT_IN_DB")
        assert "which dock is the nearest is not known: the pose of the dock" in report["error_msg"]
        assert all(message.twist.twist == Twist() for message in here.truth.messages)
