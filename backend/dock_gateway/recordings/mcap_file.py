"""MCAP files: written in small pieces that can be read after a crash.

`mcap` is imported with the first file: it takes 9 MB.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from dock_gateway.core.graph import FEEDBACK_TYPE
from dock_gateway.ros.messages.full_definition import full_definition
from dock_gateway.ros.messages.interfaces import load_message
from robot_io.recording import EVENT, TYPE, Sample

EVENT_SCHEMA = b'{"title":"dock_gateway/Event","type":"object"}'
METADATA = "dock_gateway"


class McapFile:
    """An MCAP file that is being written.

    Args:
        output: Where it is written to.
    """

    def __init__(self, output: BinaryIO) -> None:
        from mcap.writer import Writer  # noqa: PLC0415 - see above

        self._output = output
        self._writer: Any = Writer(output)
        self._writer.start("ros2", "dock-gateway")
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self._numbers: dict[int, int] = {}

    def write(self, samples: Iterable[Sample]) -> None:
        """Write messages, so that they are in the file whatever happens to this process.

        Raises:
            OSError: The disk does not take them.
        """
        for sample in samples:
            channel = self._channels.get((sample.topic, sample.kind)) or self._open(sample.topic, sample.kind)
            self._numbers[channel] = number = self._numbers.get(channel, 0) + 1
            self._writer.add_message(
                channel,
                log_time=sample.received_ns,
                publish_time=sample.source_ns or sample.received_ns,
                sequence=number & 0xFFFFFFFF,
                data=sample.data,
            )
        self._writer.flush()

    def _open(self, topic: str, kind: str) -> int:
        event = kind == EVENT
        if kind not in self._schemas:
            schema = (EVENT, "jsonschema", EVENT_SCHEMA) if event else ros_schema(kind)
            self._schemas[kind] = self._writer.register_schema(*schema)
        encoding = "json" if event else "cdr"
        channel: int = self._writer.register_channel(topic, encoding, self._schemas[kind], {TYPE: kind})
        self._channels[topic, kind] = channel
        return channel

    def finish(self, about: Mapping[str, str]) -> None:
        """Write the index, and what the recording is about.

        Raises:
            OSError: The disk does not take it.
        """
        self._writer.add_metadata(METADATA, dict(about))
        self._writer.finish()
        self._output.flush()


def ros_schema(kind: str) -> tuple[str, str, bytes]:
    """Return the name, the encoding and the text of a message type's schema.

    ROS's rules for names in definitions allow no `_`, and readers refuse `Dock_FeedbackMessage` and `Dock_Feedback`.
    Here they are `DockFeedbackMessage` and `DockFeedback`; the channel's metadata has the name that ROS uses.
    """
    text = full_definition(load_message(kind))
    package, _, name = kind.split("/")
    action = name.removesuffix(FEEDBACK_TYPE)
    if action != name:
        text = text.replace(f"{package}/{action}_", f"{package}/{action}")
        kind = kind.replace(name, name.replace("_", ""))
    return kind, "ros2msg", text.encode()


def read_last(path: Path, kind: str) -> Sample | None:
    """Return the last message of a type in a finished file.

    Raises:
        OSError: There is no such file.
    """
    from mcap.reader import make_reader  # noqa: PLC0415 - see above

    with path.open("rb") as file:
        reader: Any = make_reader(file)
        if (summary := reader.get_summary()) is None:
            return None
        wanted = {schema.id for schema in summary.schemas.values() if schema.name == kind}
        topics = [channel.topic for channel in summary.channels.values() if channel.schema_id in wanted]
        for _, channel, message in reader.iter_messages(topics=topics, reverse=True) if topics else ():
            return Sample(channel.topic, kind, message.data, message.publish_time, message.log_time)
    return None
