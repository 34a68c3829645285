"""What the docking server hears of sensors, over DDS."""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter

from docking.core.errors import FailedToDetectDock
from docking.core.geometry import Pose
from docking.core.observation import Observation, Velocity
from docking.core.transform import spatial, tilt
from docking.goal.behavior import Failed
from docking.goal.plan import KnownPoses, SingleStage
from docking.ros import transforms
from docking.ros.geometry import pose_in_space, transform_message
from robot_io.qos import LATCHED
from robot_io.transform import Transform
from tests.support.docking import ABORTED, LOW, Reports, dock_server, send_dock_goal
from tests.support.observer import Observer
from tests.support.sensors import detection, infrared, odometry, stamp
from tests.support.waiting import wait_until
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.ros

NODE = "connect_to_charging_dock_action_server"
ODOM, MARKER = "odom", "detected_dock_pose"
SENSORS = {
    "rotate": set(),
    "dock_pose": {"/odom", "/detected_dock_pose", "/tf"},
    "infrared": {"/odom", "/infrared/left", "/infrared/center", "/infrared/right"},
}
POSES = {"/dock_pose", "/filtered_dock_pose", "/staging_pose", "/plan"}
ONE_METRE = Transform((1.0, 0.0, 0.0))
AT = 1000.0  # the clock that stamps the sensors' messages need not be any other's


class Witness:
    """A controller that stands still and remembers what it was told."""

    def __init__(self) -> None:
        self.seen = Observation(0.0)

    def step(self, observation: Observation, _dt: float) -> Velocity:
        self.seen = observation
        return Velocity()


@contextmanager
def witness(domain: int, observer: Observer, controller: str, *parameters: str) -> Iterator[Witness]:
    """A witness of what the server hears while a goal runs."""
    controllers = Witness()
    with (
        dock_server(
            domain, f"controller:={controller}", *parameters, make_plan=lambda _settings: SingleStage(controllers)
        ),
        observer.publishing(LOW, "battery_status"),
    ):
        assert send_dock_goal(observer).accepted
        yield controllers


def link(parent: str, child: str, transform: Transform = ONE_METRE, at: float = AT) -> TransformStamped:
    message = TransformStamped(child_frame_id=child, transform=transform_message(transform))
    message.header.frame_id = parent
    message.header.stamp = stamp(at)
    return message


def publish_fixed(observer: Observer, *links: TransformStamped) -> None:
    publisher = observer.call(lambda: observer.node.create_publisher(TFMessage, "tf_static", LATCHED))
    observer.call(lambda: publisher.publish(TFMessage(transforms=list(links))))


def close_to(pose: Pose) -> object:
    return pytest.approx((pose.x, pose.y, pose.theta), abs=1e-6)


def as_tuple(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.theta


def test_it_listens_to_what_the_controller_needs_and_to_nothing_else(domain: int, observer: Observer) -> None:
    everything = set().union(*SENSORS.values())

    def heard() -> set[str]:
        return everything & {name for name, _ in observer.node.get_subscriber_names_and_types_by_node(NODE, "/")}

    def said() -> set[str]:
        return POSES & {name for name, _ in observer.node.get_publisher_names_and_types_by_node(NODE, "/")}

    with dock_server(domain) as server, observer.publishing(LOW, "battery_status"):
        wait_until(lambda: NODE in observer.node.get_node_names(), "the node")
        for controller in ("rotate", "dock_pose", "infrared"):
            (answer,) = server.set_parameters([Parameter("controller", value=controller)])
            assert answer.successful
            wait_until(lambda name=controller: said() == (POSES if name == "dock_pose" else set()), "the poses")
            assert heard() == set()
            goal = send_dock_goal(observer)
            wait_until(lambda name=controller: heard() == SENSORS[name], f"what {controller} listens to")
            assert goal.cancel()
            wait_until(lambda: heard() == set(), "the end of the goal, after which it listens to nothing")


def test_a_detection_is_put_where_the_robot_was_when_it_saw_the_marker(domain: int, observer: Observer) -> None:
    with witness(domain, observer, "dock_pose") as told:
        observer.publish(odometry(Pose(1.0, 0.0, math.pi / 2), AT), ODOM)
        wait_until(lambda: told.seen.odometry, "odometry")
        observer.publish(odometry(Pose(2.0, 0.0, math.pi / 2), AT + 1.0, speed=0.2), ODOM)
        wait_until(lambda: told.seen.odometry and told.seen.odometry.pose.x == 2.0, "newer odometry")
        observer.publish(detection(Pose(1.0, 0.0, 0.5), AT + 0.5), MARKER)
        marker = wait_until(lambda: told.seen.marker, "the marker")
        assert as_tuple(marker.pose) == close_to(Pose(1.5, 1.0, math.pi / 2 + 0.5))
        assert told.seen.odometry is not None
        assert told.seen.odometry.velocity == Velocity(0.2, 0.0)
        assert marker.stamp < told.seen.odometry.stamp


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        ("robot1/odom", Pose(3.0, 0.5, 0.1)),
        ("/robot1/odom", Pose(3.0, 0.5, 0.1)),
        ("robot1/base", Pose(4.0, 0.5, 0.1)),
    ],
)
def test_frames_are_those_that_odometry_names(domain: int, observer: Observer, frame: str, expected: Pose) -> None:
    with witness(domain, observer, "dock_pose") as told:
        observer.publish(odometry(Pose(1.0, 0.0, 0.0), AT, frame="robot1/odom", child="robot1/base"), ODOM)
        wait_until(lambda: told.seen.odometry, "odometry")
        observer.publish(detection(Pose(3.0, 0.5, 0.1), AT, frame), MARKER)
        marker = wait_until(lambda: told.seen.marker, "the marker")
        assert as_tuple(marker.pose) == close_to(expected)


@pytest.mark.parametrize(
    ("sent", "complaint"),
    [
        ([], "no transform has 'camera_optical_frame' or 'base_link'"),
        ([("camera_link", "camera_optical_frame")], "no transform has 'base_link'"),
        (
            [("camera_link", "camera_optical_frame"), ("base_footprint", "base_link")],
            "no transform relates 'camera_link' to 'base_footprint'",
        ),
    ],
)
def test_a_frame_that_cannot_be_related_is_told(
    domain: int, observer: Observer, sent: list[tuple[str, str]], complaint: str
) -> None:
    with witness(domain, observer, "dock_pose") as told, observer.publishing(odometry(Pose(), AT), ODOM):
        reports = Reports(observer)
        log = observer.record(Log, "/rosout")
        wait_until(lambda: told.seen.odometry, "odometry")
        if sent:
            publish_fixed(observer, *(link(*frames) for frames in sent))
        whole = (
            "/detected_dock_pose is given in the frame 'camera_optical_frame', which cannot be related to 'base_link'"
            f" by /tf or /tf_static: {complaint}"
        )
        with observer.publishing(detection(Pose(1.0, 0.0, 0.0), AT, "camera_optical_frame"), MARKER):
            report = reports.wait_for(name=f"{NODE}: sensors", level=2, message=whole)
            assert report["/detected_dock_pose"] == whole
            log.wait_for(lambda entry: entry.msg == whole)
            assert told.seen.marker is None
        observer.publish(detection(Pose(1.0, 0.0, 0.0), AT), MARKER)
        wait_until(lambda: told.seen.marker, "the marker")
        wait_until(lambda: reports.all[-1]["message"] == "ok", "a report that all is well")


def test_a_detection_is_found_over_frames_that_move_and_that_do_not(domain: int, observer: Observer) -> None:
    """A camera on a mast that turns to the left; names without the robot's prefix get it."""
    with (
        witness(domain, observer, "dock_pose", "frame_prefix:=robot1/") as told,
        observer.publishing(odometry(Pose(5.0, 0.0, 0.0), AT + 0.5), ODOM),
    ):
        optical = Transform((0.1, 0.0, 0.0), (-0.5, 0.5, -0.5, 0.5))
        publish_fixed(observer, link("robot1/mast", "camera", optical))
        for at, theta in ((AT, 0.0), (AT + 1.0, math.pi)):
            mast = link("base_link", "robot1/mast", spatial(Pose(0.0, 0.2, theta), 0.5), at)
            observer.publish(TFMessage(transforms=[mast]), "tf")
        seen = detection(Pose(), AT + 0.5, "/camera")
        seen.pose.position.z = 2.0  # ahead of the camera
        seen.pose.orientation = pose_in_space(optical.inverse()).orientation
        with observer.publishing(seen, MARKER):
            marker = wait_until(lambda: told.seen.marker, "the marker")
        assert as_tuple(marker.pose) == close_to(Pose(5.0, 2.3, math.pi / 2))


def test_an_old_transform_is_told(domain: int, observer: Observer) -> None:
    with witness(domain, observer, "dock_pose"), observer.publishing(odometry(Pose(), AT), ODOM):
        reports = Reports(observer)
        observer.publish(TFMessage(transforms=[link("base_link", "camera", at=AT - 4.0)]), "tf")
        complaint = "the transform from 'camera' to 'base_link' is 4.0 s older than the measurement"
        with observer.publishing(detection(Pose(1.0, 0.0, 0.0), AT, "camera"), MARKER):
            wait_until(lambda: any(complaint in report["message"] for report in reports.all), complaint)


def test_without_tf2_msgs_other_frames_cannot_be_related(
    domain: int, observer: Observer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transforms, "TFMessage", None)
    with witness(domain, observer, "dock_pose"), observer.publishing(odometry(Pose(), AT), ODOM):
        reports = Reports(observer)
        complaint = "cannot be related to 'base_link': tf2_msgs is not installed"
        with observer.publishing(detection(Pose(1.0, 0.0, 0.0), AT, "camera"), MARKER):
            wait_until(lambda: any(complaint in report["message"] for report in reports.all), complaint)


def test_the_axes_of_the_marker_are_turned(domain: int, observer: Observer) -> None:
    april_tag = "external_detection_rotation_roll:=-1.570796", "external_detection_rotation_pitch:=1.570796"
    with witness(domain, observer, "dock_pose", *april_tag) as told, observer.publishing(odometry(Pose(), AT), ODOM):
        reports = Reports(observer)
        tag = detection(Pose(1.0, 0.0, 0.0), AT)
        tag.pose.orientation = pose_in_space(tilt(-math.pi / 2, math.pi / 2).inverse()).orientation
        with observer.publishing(tag, MARKER):
            marker = wait_until(lambda: told.seen.marker, "the marker")
        assert as_tuple(marker.pose) == close_to(Pose(1.0, 0.0, 0.0))
        with observer.publishing(detection(Pose(1.0, 0.0, 0.0), AT), MARKER):  # as if it had no such axes
            complaint = "has an x axis that points down and so has no heading"
            wait_until(lambda: any(complaint in report["message"] for report in reports.all), complaint)


SOMEWHERE = Pose(1.0, 0.0, 0.0)
NOWHERE = Pose(math.nan, 0.0, 0.0)


def without_orientation() -> PoseStamped:
    message = detection(SOMEWHERE, AT)
    message.pose.orientation.w = 0.0
    return message


def too_fast() -> Odometry:
    message = odometry(SOMEWHERE, AT)
    message.twist.twist.angular.z = math.inf
    return message


@pytest.mark.parametrize(
    ("message", "topic", "complaint"),
    [
        (detection(NOWHERE, AT), MARKER, "has a pose that is not a number"),
        (without_orientation(), MARKER, "has an orientation of length 0, which a quaternion cannot have"),
        (detection(SOMEWHERE, AT - 60.0), MARKER, "is stamped 60.0 s before the latest odometry"),
        (detection(SOMEWHERE, AT + 5.0), MARKER, "is stamped 5.0 s after the latest odometry"),
        (odometry(NOWHERE, AT), ODOM, "has a pose that is not a number"),
        (too_fast(), ODOM, "has a velocity that is not a number"),
    ],
)
def test_what_cannot_be_used_is_told(
    domain: int, observer: Observer, message: Odometry | PoseStamped, topic: str, complaint: str
) -> None:
    with witness(domain, observer, "dock_pose") as told:
        reports = Reports(observer)
        observer.publish(odometry(Pose(), AT), ODOM)
        wait_until(lambda: told.seen.odometry, "odometry")
        before = told.seen
        observer.publish(message, topic)
        report = wait_until(lambda: [r for r in reports.all if complaint in r["message"]], complaint)[0]
        assert (report["level"], report["name"]) == (2, f"{NODE}: sensors")
        assert report["message"].startswith(f"/{topic} ")
        assert (told.seen.odometry, told.seen.marker) == (before.odometry, before.marker)


def test_a_detection_before_any_odometry_cannot_be_used(domain: int, observer: Observer) -> None:
    with witness(domain, observer, "dock_pose"):
        reports = Reports(observer)
        complaint = "/detected_dock_pose cannot be used: no odometry has come yet"
        with observer.publishing(detection(SOMEWHERE, AT), MARKER):
            reports.wait_for(name=f"{NODE}: sensors", message=complaint)


def test_infrared_ranges_are_read_as_their_message_says(domain: int, observer: Observer) -> None:
    with witness(domain, observer, "infrared") as told:
        reports = Reports(observer)
        observer.publish(infrared(math.inf), "infrared/left")
        observer.publish(infrared(0.5), "infrared/center")
        assert told.seen.infrared is None
        observer.publish(infrared(1.6), "infrared/right")
        reading = wait_until(lambda: told.seen.infrared, "all three")
        assert (reading.left, reading.center, reading.right) == (math.inf, 0.5, math.inf)
        observer.publish(infrared(-math.inf), "infrared/left")
        observer.publish(infrared(0.0), "infrared/center")
        wait_until(
            lambda: told.seen.infrared and told.seen.infrared.left == told.seen.infrared.center == pytest.approx(0.02),
            "what is too close",
        )
        observer.publish(infrared(math.nan), "infrared/right")
        reports.wait_for(message="/infrared/right has a range that is not a number")


class Blind:
    """A controller that never finds the dock."""

    def __init__(self) -> None:
        self.gives_up = threading.Event()

    def step(self, _observation: Observation, _dt: float) -> Velocity | Failed:
        return Failed(FailedToDetectDock("the dock was not found")) if self.gives_up.is_set() else Velocity()


def test_an_abort_says_what_is_wrong_with_the_sensors(domain: int, observer: Observer) -> None:
    blind = Blind()
    with dock_server(domain, "controller:=dock_pose", make_plan=lambda _settings: SingleStage(blind)):
        reports = Reports(observer)
        complaint = "/detected_dock_pose cannot be used: no odometry has come yet"
        with (
            observer.publishing(LOW, "battery_status"),
            observer.publishing(detection(SOMEWHERE, AT), MARKER, heard=False),
        ):
            goal = send_dock_goal(observer)
            reports.wait_for(name=f"{NODE}: sensors", message=complaint)
            blind.gives_up.set()
            assert goal.result().status == ABORTED
        report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
        assert report["error_msg"] == f"the dock was not found; {complaint}"
        assert (report["error_code"], report["error_number"]) == ("FAILED_TO_DETECT_DOCK", "904")


class Knows(SingleStage):
    """A plan that knows where everything is."""

    poses = KnownPoses(Pose(1.0, 2.0, 0.5), Pose(1.1, 2.0, 0.5), Pose(0.4, 2.0, 0.5))


def test_the_poses_are_shown_while_a_goal_runs(domain: int, observer: Observer) -> None:
    shown = {
        topic: observer.record(PoseStamped, topic) for topic in ("dock_pose", "filtered_dock_pose", "staging_pose")
    }
    told = Witness()
    with dock_server(domain, "controller:=dock_pose", make_plan=lambda _settings: Knows(told)):
        for recording in shown.values():
            recording.wait_for_publisher()
        with (
            observer.publishing(LOW, "battery_status"),
            observer.publishing(odometry(Pose(), AT, frame="robot1/odom"), ODOM, heard=False),
        ):
            goal = send_dock_goal(observer)
            for (topic, recording), x in zip(shown.items(), (1.0, 1.1, 0.4), strict=True):
                message = recording.wait_for(lambda message: message.header.frame_id == "robot1/odom")
                assert message.pose.position.x == x, topic
                assert message.pose.orientation.z == pytest.approx(math.sin(0.25))
                assert message.header.stamp.sec > 0
            assert goal.cancel()
