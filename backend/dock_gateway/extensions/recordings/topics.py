"""Chooses the topics of a robot that are recorded. Pure."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from dock_gateway.core.graph import ACTION_PART, FEEDBACK, FEEDBACK_TYPE, STATUS, TRANSFORMS
from dock_gateway.settings import Settings

CAMERA = "sensor_msgs/msg/CompressedImage"
STOP = "std_msgs/msg/Bool"
GOAL_STATES = "action_msgs/msg/GoalStatusArray"
# Those in a robot's namespace that are recorded, whatever they are called.
TYPES = frozenset(
    {
        CAMERA,
        TRANSFORMS,
        "apriltag_msgs/msg/AprilTagDetectionArray",
        "diagnostic_msgs/msg/DiagnosticArray",
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "geometry_msgs/msg/Twist",
        "geometry_msgs/msg/TwistStamped",
        "irobot_create_msgs/msg/DockStatus",
        "irobot_create_msgs/msg/HazardDetectionVector",
        "irobot_create_msgs/msg/StopStatus",
        "nav_msgs/msg/Odometry",
        "nav_msgs/msg/Path",
        "rcl_interfaces/msg/Log",
        "sensor_msgs/msg/BatteryState",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs/msg/Range",
        "vision_msgs/msg/Detection3DArray",
    }
)
# Topics of all robots together.
SHARED = ("/tf", "/tf_static", "/diagnostics", "/rosout")
MAX_TOPICS = 60


class RecordedTopic(NamedTuple):
    """A topic that is recorded: its type, and whether its messages hold until the next one."""

    kind: str
    lasting: bool = False


def recorded_topics(
    robot: str,
    settings: Settings,
    topics: Mapping[str, list[str]],
    actions: Mapping[str, list[str]],
    owner: Callable[[str], str | None],
    *,
    more: Iterable[str] = (),
) -> dict[str, RecordedTopic]:
    """Return the topics to record of a robot, with their types.

    Args:
        robot: Namespace of the robot.
        settings: Name topics.
        topics: All topics on the graph, with their types.
        actions: All actions on the graph, with their types.
        owner: Returns the robot that a topic or an action belongs to, None if to none.
        more: Further topics that are recorded.
    """

    def resolved(names: Iterable[str]) -> set[str]:
        return {settings.resolve(name, robot) for name in names}

    stops = resolved((settings.stop_state_topic, *settings.emergency_stop_topics))
    named = {settings.battery_of(robot), settings.resolve(settings.diagnostics_topic, robot), *SHARED}
    named |= resolved((settings.cmd_vel_topic,))
    further = resolved(more)
    found = {}
    for name, types in topics.items():
        if len(types) != 1:  # a mistake: nothing is subscribed to, which would add to it
            continue
        kind = types[0]
        by_type = kind in TYPES and (name in named or owner(name) == robot)
        if by_type or name in further or (name in stops and kind == STOP):
            found[name] = RecordedTopic(kind, lasting=name in stops or name.endswith("/tf_static"))
    for name, types in actions.items():
        if len(types) == 1 and owner(name) == robot:
            prefix = f"{name}{ACTION_PART}"
            found[f"{prefix}{FEEDBACK}"] = RecordedTopic(f"{types[0]}{FEEDBACK_TYPE}")
            found[f"{prefix}{STATUS}"] = RecordedTopic(GOAL_STATES)
    named |= stops | further
    first = sorted(found, key=lambda name: (name not in named and ACTION_PART not in name, name))[:MAX_TOPICS]
    return {name: found[name] for name in first}
