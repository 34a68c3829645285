"""Recordings of goals: MCAP files that the gateway writes, and `docking_replay` reads.

`mcap` is imported with the first file: it takes 9 MB.
"""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

# The topic of the gateway's own events, and their type; they are JSON.
EVENTS = "/dock_gateway/events"
EVENT = "dock_gateway/Event"
# The key in a channel's metadata with the name of its type in ROS.
TYPE = "ros_type"
# A record of more bytes is damage.
MAX_RECORD = 500_000_000


class Sample(NamedTuple):
    """A message: its topic, its type, its bytes, and when it was sent and received, in ns since 1970."""

    topic: str
    kind: str
    data: bytes
    source_ns: int
    received_ns: int


def read(path: Path) -> Iterator[Sample]:
    """Yield the messages of a file, as far as it can be read: it may end anywhere.

    Raises:
        OSError: There is no such file.
    """
    from mcap.records import Channel, Message, Schema  # noqa: PLC0415 - see above
    from mcap.stream_reader import StreamReader  # noqa: PLC0415

    channels: dict[int, Channel] = {}
    schemas: dict[int, Schema] = {}
    with path.open("rb") as file, suppress(Exception):  # whatever half a record brings about
        for record in StreamReader(file, validate_crcs=True, record_size_limit=MAX_RECORD).records:
            match record:
                case Schema():
                    schemas[record.id] = record
                case Channel():
                    channels[record.id] = record
                case Message():
                    channel = channels[record.channel_id]
                    kind = channel.metadata.get(TYPE, schemas[channel.schema_id].name)
                    yield Sample(channel.topic, kind, record.data, record.publish_time, record.log_time)
