"""The schemas that the dashboard's form is tested with are those that the gateway makes.

To write them anew: `python -m tests.dock_gateway.ros.messages.test_form_schemas`
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import orjson

from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_action

COPY = Path(__file__).parents[4] / "frontend/tests/form/schemas.json"
ACTIONS = (
    "action_tutorials_interfaces/action/ConnectToChargingDock",
    "action_tutorials_interfaces/action/Fibonacci",
    "test_msgs/action/NestedMessage",
)
# What goals of other actions are made of: poses and paths, covariances, maps, pictures, and every type that there is.
MESSAGES = (
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "nav_msgs/msg/OccupancyGrid",
    "nav_msgs/msg/Path",
    "sensor_msgs/msg/Image",
    "test_msgs/msg/Arrays",
    "test_msgs/msg/BoundedSequences",
    "test_msgs/msg/Defaults",
    "test_msgs/msg/MultiNested",
    "test_msgs/msg/Strings",
    "test_msgs/msg/UnboundedSequences",
    "trajectory_msgs/msg/JointTrajectory",
    "unique_identifier_msgs/msg/UUID",
    "visualization_msgs/msg/InteractiveMarker",
)


def schemas() -> dict[str, Any]:
    """The schema of each goal and message, as it is taken."""
    goals = {name: codec(load_action(name).Goal).schema() for name in ACTIONS}
    return goals | {name: codec(message_class(name)).schema() for name in MESSAGES}


def message_class(name: str) -> type[Any]:
    package, _, short = name.split("/")
    found: type[Any] = getattr(import_module(f"{package}.msg"), short)
    return found


def test_the_copy_is_fresh() -> None:
    fresh = orjson.loads(orjson.dumps(schemas()))
    assert orjson.loads(COPY.read_bytes()) == fresh, "run python -m tests.dock_gateway.ros.messages.test_form_schemas"


if __name__ == "__main__":
    COPY.write_bytes(orjson.dumps(schemas(), option=orjson.OPT_APPEND_NEWLINE))
