"""Which topics of a robot are recorded."""

from dock_gateway.extensions.recordings.topics import CAMERA, MAX_TOPICS, RecordedTopic, recorded_topics
from dock_gateway.settings import Settings

SCAN, BOOL, TRANSFORMS = "sensor_msgs/msg/LaserScan", "std_msgs/msg/Bool", "tf2_msgs/msg/TFMessage"
TOPICS = {
    "/tf": [TRANSFORMS],
    "/tf_static": [TRANSFORMS],
    "/robot1/scan": [SCAN],
    "/robot1/camera/image/compressed": [CAMERA],
    "/robot1/camera/image": ["sensor_msgs/msg/Image"],
    "/robot1/imu": ["sensor_msgs/msg/Imu"],
    "/robot1/stop_latched": [BOOL],
    "/robot2/scan": [SCAN],
    "/rosout": ["rcl_interfaces/msg/Log"],
    "/robot1/battery_status": ["std_msgs/msg/String"],
    "/robot1/odom": ["nav_msgs/msg/Odometry", "std_msgs/msg/String"],
}


def recorded(topics: dict[str, list[str]], *more: str) -> dict[str, RecordedTopic]:
    actions = {"/robot1/dock": ["pkg/action/Dock"], "/robot2/dock": ["pkg/action/Dock"]}
    return recorded_topics("/robot1", Settings(), topics, actions, lambda name: f"/{name.split('/')[1]}", more=more)


def test_by_name_by_type_and_by_setting() -> None:
    found = recorded(TOPICS, "imu")
    assert found == {
        "/tf": RecordedTopic(TRANSFORMS),
        "/tf_static": RecordedTopic(TRANSFORMS, lasting=True),
        "/robot1/scan": RecordedTopic(SCAN),
        "/robot1/camera/image/compressed": RecordedTopic(CAMERA),
        "/robot1/imu": RecordedTopic("sensor_msgs/msg/Imu"),
        "/robot1/stop_latched": RecordedTopic(BOOL, lasting=True),
        "/rosout": RecordedTopic("rcl_interfaces/msg/Log"),
        "/robot1/dock/_action/feedback": RecordedTopic("pkg/action/Dock_FeedbackMessage"),
        "/robot1/dock/_action/status": RecordedTopic("action_msgs/msg/GoalStatusArray"),
    }


def test_with_too_many_topics_those_of_the_goal_come_first() -> None:
    found = recorded(TOPICS | {f"/robot1/a{number}": [SCAN] for number in range(2 * MAX_TOPICS)})
    assert len(found) == MAX_TOPICS
    assert {"/tf", "/robot1/dock/_action/feedback"} <= found.keys()
