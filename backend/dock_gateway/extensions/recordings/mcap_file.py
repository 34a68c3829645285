"""MCAP files: written in small pieces that can be read after a crash, and such that `ros2 bag` opens them.

rosbag2 refuses a file in which two topics have another encoding (all are `cdr` here), or without statistics. Each
channel has the quality of service that rosbag2 publishes a topic with.

`mcap` is imported with the first file: it takes 9 MB.
"""

import logging
from collections.abc import Iterable, Mapping
from typing import Any, BinaryIO

from dock_gateway.core.graph import FEEDBACK_TYPE
from dock_gateway.extensions.recordings.type_hash import type_hash
from dock_gateway.ros.messages.full_definition import full_definition
from dock_gateway.ros.messages.interfaces import load_message
from robot_io.recording import QOS, TYPE, TYPE_HASH, Sample

log = logging.getLogger(__name__)

METADATA = "dock_gateway"


class McapFile:
    """An MCAP file that is being written.

    Args:
        output: Where it is written to.

    Attributes:
        uncompressed_bytes: Bytes of all messages, without compression.
    """

    def __init__(self, output: BinaryIO) -> None:
        from mcap.writer import Writer  # noqa: PLC0415 - see above

        self.uncompressed_bytes = 0
        self._output = output
        self._writer: Any = Writer(output)
        self._writer.start("ros2", "dock-gateway")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, tuple[str, int | None]] = {}
        self._numbers: dict[int, int] = {}

    def write(self, samples: Iterable[Sample]) -> None:
        """Write messages, so that they are in the file whatever happens to this process.

        A topic keeps the type of its first message, and has no messages if that type is not installed.

        Raises:
            OSError: The disk does not take them.
        """
        for sample in samples:
            kind, channel = self._channels.get(sample.topic) or self._open(sample)
            if channel is None or kind != sample.kind:
                continue
            self._numbers[channel] = number = self._numbers.get(channel, 0) + 1
            self.uncompressed_bytes += len(sample.data)
            self._writer.add_message(
                channel,
                log_time=sample.received_ns,
                publish_time=sample.source_ns or sample.received_ns,
                sequence=number & 0xFFFFFFFF,
                data=sample.data,
            )
        self._writer.flush()

    def _open(self, sample: Sample) -> tuple[str, int | None]:
        topic, kind = sample.topic, sample.kind
        channel: int | None = None
        try:
            if kind not in self._schemas:
                self._schemas[kind] = self._writer.register_schema(*ros_schema(kind))
            known = {QOS: sample.qos, TYPE_HASH: type_hash(kind)}
            about = {TYPE: kind} | {name: value for name, value in known.items() if value}
            channel = self._writer.register_channel(topic, "cdr", self._schemas[kind], about)
        except (ImportError, TypeError) as error:
            log.warning("%s is left out of a recording: %s", topic, error)
        self._channels[topic] = kind, channel
        return kind, channel

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
