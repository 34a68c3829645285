"""Finds a robot's cameras among the topics on the graph. Pure."""

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from dock_gateway.core.filters import is_hidden, is_under, prefix_of
from dock_gateway.core.graph import Topic

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
# Forms of the camera `image_raw` by the convention of image_transport, the best first: `image_raw/compressed` costs the
# least, and `image_raw/compressedDepth` takes the most time to read.
PARTS = ("/compressed", "", "/compressedDepth")
# A form that is not shown.
OTHER_PARTS = ("/zstd",)


class Form(NamedTuple):
    """A topic of a camera's pictures, and its type."""

    topic: str
    type: str


@dataclass(frozen=True)
class Camera:
    """A camera of a robot.

    Attributes:
        name: Its topic relative to the robot's namespace, without what image_transport appends.
        forms: The topics of its pictures, the best first.
    """

    name: str
    forms: tuple[Form, ...]

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics of its pictures, the best first."""
        return tuple(form.topic for form in self.forms)


def find_cameras(robot: str, topics: Iterable[Topic], belongs: Callable[[str], bool]) -> list[Camera]:
    """Return the cameras of a robot, by name.

    Args:
        robot: The robot's namespace.
        topics: The topics with pictures.
        belongs: Whether a topic is the robot's and may be read.
    """
    found: defaultdict[str, list[tuple[int, Form]]] = defaultdict(list)
    for topic in topics:
        if not is_under(topic.name, robot) or is_hidden(topic.name, robot) or not belongs(topic.name):
            continue
        if topic.name.endswith(OTHER_PARTS):
            continue
        types = {endpoint.type for endpoint in topic.publishers} & {IMAGE, COMPRESSED}
        if types:
            kind = min(types)  # of two, which is a mistake, that which is compressed
            part = ""
            if kind == COMPRESSED:
                part = next((part for part in PARTS if part and topic.name.endswith(part)), "")
            found[topic.name.removesuffix(part)].append((PARTS.index(part), Form(topic.name, kind)))
    return [
        Camera(base.removeprefix(prefix_of(robot)), tuple(form for _, form in sorted(forms)))
        for base, forms in sorted(found.items())
    ]
