"""Docking by a marker that a camera sees in its own frame, on a robot whose odometry is that of its footprint."""

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry

from docking.core.geometry import Pose
from docking.ros import simulator_frames
from tests.support.docking import ABORTED, FAST, SUCCEEDED, UNMEASURED, Reports, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.waiting import wait_until
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.ros

NEAR = "start_x:=-1.2", "start_y:=0.1", "start_theta:=0.1"
FRAMES = "detection_frame:=camera_optical_frame", "odometry_child_frame:=base_footprint"
NODE = "connect_to_charging_dock_action_server"


def test_a_robot_docks_by_what_its_camera_sees(domain: int, observer: Observer) -> None:
    topics = {"tf": TFMessage, "odom": Odometry, "detected_dock_pose": PoseStamped}
    with (
        dock_simulator(domain, *NEAR, *FRAMES, FAST) as simulator,
        docking_servers(domain, "controller:=dock_pose", UNMEASURED),
    ):
        heard = {topic: observer.record(message_type, topic) for topic, message_type in topics.items()}
        heard["odom"].wait_for(lambda message: message.child_frame_id == "base_footprint")
        seen = heard["detected_dock_pose"].wait_for(lambda message: message.header.frame_id == "camera_optical_frame")
        assert seen.pose.position.z == pytest.approx(1.0, abs=0.1)  # straight ahead
        heard["tf"].wait_for(lambda message: message.transforms[0].child_frame_id == "base_footprint")
        assert send_dock_goal(observer).result().status == SUCCEEDED
        docked = simulator.simulation.robot.pose.relative_to(Pose(-0.2))
        assert abs(docked.x) < 0.03
        assert abs(docked.y) < 0.02


def test_the_goal_names_the_frames_that_are_not_related(
    domain: int, observer: Observer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulator_frames, "TFMessage", None)  # the robot says nothing of its frames
    with (
        dock_simulator(domain, *NEAR, *FRAMES),
        docking_servers(domain, "controller:=dock_pose", "initial_perception_timeout:=3.0"),
    ):
        reports = Reports(observer)
        goal = send_dock_goal(observer)
        assert goal.result().status == ABORTED
        report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
        assert report["error_code"] == "FAILED_TO_DETECT_DOCK"
        assert report["error_msg"].endswith(
            "'camera_optical_frame', which cannot be related to 'base_footprint' by /tf or /tf_static: no transform has"
            " 'camera_optical_frame' or 'base_footprint'"
        )
        wait_until(
            lambda: (
                not {"/tf", "/odom"}
                & {name for name, _ in observer.node.get_subscriber_names_and_types_by_node(NODE, "/")}
            ),
            "the end of the goal, after which the server listens no longer",
        )
