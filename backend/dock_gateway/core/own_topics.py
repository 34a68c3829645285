"""Topics whose type follows from their name, because the gateway itself uses them.

A DDS participant has one type for each topic. If a client could choose that of a robot's stop before the robot is
there, the gateway could not publish the stop. If another node could choose that of an action's status, the gateway
could not use the action.
"""

from dataclasses import dataclass
from fnmatch import fnmatchcase

from dock_gateway.core.graph import ACTION_PART, FEEDBACK, STATUS, TRANSFORMS
from dock_gateway.settings import Settings
from robot_io.velocity_types import TYPES as VELOCITY


@dataclass(frozen=True)
class OwnTopic:
    """A topic of the gateway, or one of each robot.

    Attributes:
        name: Its name; a relative one is that of each robot.
        types: Its types; `*` in one stands for any text.
        fixed: Whether it is never used with another type. Otherwise one that a node has there can be read: PX4 has a
            `battery_status` of its own.
    """

    name: str
    types: frozenset[str]
    fixed: bool = False

    def is_at(self, topic: str) -> bool:
        """Return whether an absolute name is this topic."""
        return topic == self.name or (self.name[0] != "/" and topic.endswith(f"/{self.name}"))

    def has(self, kind: str) -> bool:
        """Return whether a type is one of its types."""
        return any(fnmatchcase(kind, each) for each in self.types)


class OwnTopics:
    """The gateway's own topics.

    Args:
        settings: Their names.
    """

    def __init__(self, settings: Settings) -> None:
        stops = dict.fromkeys((settings.stop_state_topic, *settings.emergency_stop_topics))
        self._topics = (
            *(OwnTopic(name, frozenset({"std_msgs/msg/Bool"}), fixed=True) for name in stops),
            OwnTopic(settings.cmd_vel_topic, frozenset(VELOCITY), fixed=True),
            OwnTopic("initialpose", frozenset({"geometry_msgs/msg/PoseWithCovarianceStamped"}), fixed=True),
            OwnTopic(f"{ACTION_PART[1:]}{STATUS}", frozenset({"action_msgs/msg/GoalStatusArray"}), fixed=True),
            OwnTopic(f"{ACTION_PART[1:]}{FEEDBACK}", frozenset({"*/action/*_FeedbackMessage"}), fixed=True),
            OwnTopic(settings.battery_topic, frozenset({"sensor_msgs/msg/BatteryState"})),
            OwnTopic(settings.diagnostics_topic, frozenset({"diagnostic_msgs/msg/DiagnosticArray"})),
            OwnTopic("/tf", frozenset({TRANSFORMS})),
            OwnTopic("/tf_static", frozenset({TRANSFORMS})),
        )

    def find(self, topic: str) -> OwnTopic | None:
        """Return the gateway's own topic of an absolute name, if it is one."""
        return next((own for own in self._topics if own.is_at(topic)), None)
