"""What is on the ROS graph: actions with their types, and topics."""

from dataclasses import dataclass, field

from rclpy.node import Node

FEEDBACK, STATUS = "/_action/feedback", "/_action/status"
FEEDBACK_TYPE = "_FeedbackMessage"


@dataclass(frozen=True)
class Scan:
    """One look at the graph.

    Attributes:
        actions: Names of the actions that someone serves, with their types (more than one is a mistake on the graph).
        topics: Names of topics, without those inside of actions, with their types.
    """

    actions: dict[str, list[str]] = field(default_factory=dict)
    topics: dict[str, list[str]] = field(default_factory=dict)


def scan(node: Node) -> Scan:
    """Look at the graph; for the ROS thread.

    An action is on the graph as soon as anybody, we included, listens to it. Only where somebody publishes its status
    there is a server.
    """
    result = Scan()
    for topic, types in node.get_topic_names_and_types():
        if topic.endswith(FEEDBACK):
            name = topic.removesuffix(FEEDBACK)
            if node.count_publishers(f"{name}{STATUS}"):
                result.actions[name] = [text.removesuffix(FEEDBACK_TYPE) for text in types]
        elif "/_action/" not in topic:
            result.topics[topic] = list(types)
    return result
