"""Which cameras a robot has, by the topics on the graph. Pure."""

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from dock_gateway.core.filters import is_hidden, is_under, prefix_of
from dock_gateway.core.graph import Topic

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
# `image_raw/compressed` is the camera `image_raw`, by the convention of image_transport.
COMPRESSED_PART = "/compressed"
# Other forms of a camera's pictures, which image_transport publishes beside it and browsers do not show.
OTHER_PARTS = ("/compressedDepth", "/zstd")


@dataclass(frozen=True)
class Camera:
    """A camera of a robot.

    Attributes:
        name: Its topic relative to the robot's namespace, without `/compressed`.
        topic: The topic of its pictures, compressed ones if there are any.
        type: The type of that topic.
    """

    name: str
    topic: str
    type: str


def find_cameras(robot: str, topics: Iterable[Topic], belongs: Callable[[str], bool]) -> list[Camera]:
    """Return the cameras of a robot, by name.

    Args:
        robot: The robot's namespace.
        topics: The topics with pictures.
        belongs: Whether a topic is the robot's and may be read.
    """
    found: defaultdict[str, dict[str, str]] = defaultdict(dict)
    for topic in topics:
        if not is_under(topic.name, robot) or is_hidden(topic.name, robot) or not belongs(topic.name):
            continue
        if topic.name.endswith(OTHER_PARTS):
            continue
        for kind in {endpoint.type for endpoint in topic.publishers} & {IMAGE, COMPRESSED}:
            base = topic.name.removesuffix(COMPRESSED_PART) if kind == COMPRESSED else topic.name
            found[base][kind] = topic.name
    cameras = []
    for base, forms in sorted(found.items()):
        kind = COMPRESSED if COMPRESSED in forms else IMAGE
        cameras.append(Camera(base.removeprefix(prefix_of(robot)), forms[kind], kind))
    return cameras
