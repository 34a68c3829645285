"""Docking by localization alone, over DDS: the programs that users start, by nav2's file without a detector."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED
from tests.support.docking import ABORTED, FAST, SUCCEEDED, UNMEASURED, send_dock_goal, send_undock_goal
from tests.support.observer import Observer
from tests.support.processes import Process, ros_environment
from tests.support.site import NEAR, assert_docked, look_at, site
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.ros

FILE = """
docking_server:
  ros__parameters:
    dock_plugins: [wall_dock]
    wall_dock:
      plugin: opennav_docking::SimpleChargingDock
      use_external_detection_pose: false
      use_battery_status: true
      staging_x_offset: -0.6
    docks: [home]
    home: {type: wall_dock, frame: map, pose: [-0.2, 0.0, 0.0]}
"""
PARAMETERS = "use_external_detection_pose:=false", "docks:=[home]", "home.pose:=[-0.2, 0.0, 0.0]"


@contextmanager
def localizing(observer: Observer) -> Iterator[None]:
    """A localization that says where the robot began, until it dies."""
    ends = threading.Event()

    def publish() -> None:
        while not ends.wait(0.1):
            stamped = TransformStamped(child_frame_id="odom")
            stamped.header.frame_id = "map"
            stamped.header.stamp = observer.node.get_clock().now().to_msg()
            stamped.transform.translation.x = NEAR.x
            stamped.transform.rotation.w = 1.0
            observer.publish(TFMessage(transforms=[stamped]), "tf")

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        ends.set()
        thread.join()


def test_a_robot_without_a_marker_docks_and_undocks(domain: int, observer: Observer, tmp_path: Path) -> None:
    path = tmp_path / "nav2.yaml"
    path.write_text(FILE)
    environment = ros_environment(domain)
    off = "localization_error_x:=0.02", "localization_error_y:=0.04", "localization_error_yaw:=0.03"
    robot = [text for value in (FAST, "switched_detector:=true", *off) for text in ("-p", value)]
    with (
        Process("dock_simulator", "--ros-args", *robot, env=environment),
        Process("docking_server", "--ros-args", "-p", UNMEASURED, "--params-file", str(path), env=environment),
    ):
        here = look_at(observer)
        detections = observer.record(PoseStamped, "detected_dock_pose")
        here.place(Pose(-1.3, 0.2, -0.2))
        goal = send_dock_goal(observer, dock="home")
        assert goal.result(180.0).status == SUCCEEDED
        assert_docked(here.pose)
        here.expect_standstill()
        assert not detections.messages
        assert not observer.node.get_subscriptions_info_by_topic("/detected_dock_pose")[1:], "only the test listens"

        undocking = send_undock_goal(observer)
        assert undocking.result(20.0).status == SUCCEEDED
        here.expect_standstill()
        assert here.pose.relative_to(DOCKED).x == pytest.approx(-0.6, abs=0.1)


def test_a_robot_does_not_dock_by_a_localization_that_is_lost(domain: int, observer: Observer) -> None:
    """The server hears of that while a goal runs."""
    with site(domain, observer, *PARAMETERS, "initial_perception_timeout:=3.0", "max_retries:=0") as here:
        message = PoseWithCovarianceStamped()
        message.pose.covariance[0] = 0.81
        with observer.publishing(message, "amcl_pose", heard=False):
            goal = send_dock_goal(observer)
            assert goal.result(60.0).status == ABORTED
        report = here.reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
        assert report["error_code"] in {"FAILED_TO_DETECT_DOCK", "LOCALIZATION_LOST"}
        assert here.pose.distance_to(DOCKED) > 0.3


def test_a_localization_that_dies_is_noticed_though_its_last_transform_stays(domain: int, observer: Observer) -> None:
    """Its process is killed: tf has its last word, and no newer one."""
    with site(domain, observer, *PARAMETERS, "max_retries:=0", robot=("publish_map:=false",)) as here:
        with localizing(observer):
            goal = send_dock_goal(observer)
            here.wait_for_stage(goal, "CONTROLLING")
        here.expect_abort(goal, "LOCALIZATION_LOST", within=20.0)


def test_a_robot_undocks_though_its_pose_on_the_map_is_far_off(domain: int, observer: Observer) -> None:
    """It was switched on at its dock, and its localization has not found itself yet."""
    off = "localization_error_x:=0.6", "localization_error_y:=0.53", "localization_error_yaw:=0.35"
    with site(domain, observer, *PARAMETERS, robot=off) as here:
        here.place(DOCKED)
        here.controls.wait_for_status(docked="true")
        assert send_undock_goal(observer).result(30.0).status == SUCCEEDED
        here.expect_standstill()
        assert here.pose.relative_to(DOCKED).x == pytest.approx(-0.7, abs=0.1)
        assert abs(here.pose.y) < 0.05
