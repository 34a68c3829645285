"""Recordings of goals: MCAP files that the gateway writes, and `docking_replay` reads.

A file may be damaged or made up: whatever bytes it has, reading it ends, and needs a bounded amount of memory.

`mcap` is imported with the first file: it takes 9 MB.
"""

import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from errno import EINVAL
from io import SEEK_END, BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

# The topic of the gateway's own events, and its type: each message is a JSON document. A file whose topics do not have
# all the same encoding is refused by rosbag2.
EVENTS = "/dock_gateway/events"
EVENT = "std_msgs/msg/String"
# Keys in a channel's metadata: the name of its type in ROS; those of rosbag2.
TYPE, QOS, TYPE_HASH = "ros_type", "offered_qos_profiles", "topic_type_hash"
# Bytes of a record, and of a chunk without its compression; more is damage.
MAX_RECORD = 200_000_000
# Bytes without compression, and messages, of a file that are read. The gateway writes fewer.
MAX_BYTES, MAX_MESSAGES = 2_000_000_000, 10_000_000
# Bytes of the footer, and of what ends a file.
FOOTER = 9 + 20 + 8
# What precedes a serialized message: CDR, little-endian.
CDR = b"\0\1\0\0"


class Sample(NamedTuple):
    """A message: its topic, its type, its bytes, and when it was sent and received, in ns since 1970.

    `qos` is the quality of service that its publishers offer, as rosbag2 writes it; empty if unknown.
    """

    topic: str
    kind: str
    data: bytes
    source_ns: int
    received_ns: int
    qos: str = ""


def event_sample(document: bytes, at_ns: int) -> Sample:
    """Return an event of the gateway as a message.

    Args:
        document: A JSON document.
        at_ns: When it happened, in ns since 1970.
    """
    data = CDR + struct.pack("<I", len(document) + 1) + document + b"\0"
    return Sample(EVENTS, EVENT, data, at_ns, at_ns)


def event_text(sample: Sample) -> bytes:
    """Return the JSON document of an event.

    Raises:
        ValueError: The message is not one that `event_sample` makes.
    """
    begin = len(CDR) + 4
    if sample.kind != EVENT or not sample.data.startswith(CDR) or len(sample.data) <= begin:
        raise ValueError("it is not a text")
    (length,) = struct.unpack_from("<I", sample.data, len(CDR))
    if length < 1 or begin + length > len(sample.data):
        raise ValueError("its text is cut off")
    return sample.data[begin : begin + length - 1]


def read(path: Path) -> Iterator[Sample]:
    """Yield the messages of a file, as far as it can be read: it may end anywhere.

    Raises:
        OSError: There is no such file.
    """
    from mcap.records import Channel, Message, Schema  # noqa: PLC0415 - see above

    channels: dict[int, Channel] = {}
    schemas: dict[int, Schema] = {}
    left = MAX_MESSAGES
    with _open(path) as file, suppress(Exception):  # whatever half a record brings about
        for record in _records(file):
            match record:
                case Schema():
                    schemas[record.id] = record
                case Channel():
                    channels[record.id] = record
                case Message():
                    if (left := left - 1) < 0:
                        return
                    yield _sample(channels[record.channel_id], schemas, record)


def read_last(path: Path, kind: str) -> Sample | None:
    """Return the last message of a type in a finished file; None if its index has none.

    Raises:
        OSError: There is no such file.
    """
    from mcap.records import Channel, ChunkIndex, Message, Schema  # noqa: PLC0415 - see above

    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    chunks: list[ChunkIndex] = []
    with _open(path) as file, suppress(Exception):  # whatever an index says that is damaged
        file.seek(-FOOTER, SEEK_END)
        file.seek(next(_stream(file).records).summary_start)
        for record in _stream(file).records:
            match record:
                case Schema(name=name) if name == kind:
                    schemas[record.id] = record
                case Channel(schema_id=number) if number in schemas:
                    channels[record.id] = record
                case ChunkIndex() if not channels.keys().isdisjoint(record.message_index_offsets):
                    chunks.append(record)
        file.seek(max(reversed(chunks), key=lambda each: each.message_end_time).chunk_start_offset)
        records = _contents(next(_stream(file).records), MAX_RECORD)
        messages = [each for each in records if isinstance(each, Message) and each.channel_id in channels]
        last = max(reversed(messages), key=lambda each: each.log_time)
        return _sample(channels[last.channel_id], schemas, last)
    return None


def _open(path: Path) -> BinaryIO:
    if path.exists() and not path.is_file():  # a pipe may never end
        raise OSError(EINVAL, "it is not a regular file", str(path))
    return path.open("rb")


def _stream(data: BinaryIO, *, whole: bool = False) -> Any:
    from mcap.stream_reader import StreamReader  # noqa: PLC0415 - see above

    return StreamReader(data, not whole, emit_chunks=True, validate_crcs=whole, record_size_limit=MAX_RECORD)


def _records(file: BinaryIO) -> Iterator[Any]:
    """Yield the records of a file, and those in its chunks instead of these."""
    from mcap.records import Chunk  # noqa: PLC0415 - see above

    left = MAX_BYTES
    for record in _stream(file, whole=True).records:
        if file.tell() > MAX_BYTES:
            return
        if not isinstance(record, Chunk):
            yield record
            continue
        left -= record.uncompressed_size
        yield from _contents(record, min(left, MAX_RECORD))


def _contents(chunk: Any, limit: int) -> Iterator[Any]:
    """Yield the records in a chunk, which may have so many bytes.

    Raises:
        ValueError: It has more, or others than it says.
    """
    from mcap.exceptions import EndOfFile  # noqa: PLC0415 - see above

    if chunk.uncompressed_size > limit:
        raise ValueError("the chunk is too large")
    data = _decompressed(chunk.data, chunk.compression, chunk.uncompressed_size + 1)
    if len(data) != chunk.uncompressed_size or (chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc):
        raise ValueError("the chunk is damaged")
    with suppress(EndOfFile):
        yield from _stream(BytesIO(data)).records


def _decompressed(data: bytes, compression: str, limit: int) -> bytes:
    """Return what was compressed, or as many bytes of it as the limit: what is compressed may be of any size."""
    if compression == "zstd":
        import zstandard  # noqa: PLC0415 - see above

        with zstandard.ZstdDecompressor().stream_reader(data) as reader:
            return bytes(reader.read(limit))
    if compression == "lz4":
        import lz4.frame  # type: ignore[import-untyped] # noqa: PLC0415 - see above

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=limit))
    if compression:
        raise ValueError(f"the compression {compression[:20]} is unknown")
    return data


def _sample(channel: Any, schemas: dict[int, Any], message: Any) -> Sample:
    schema, about = schemas.get(channel.schema_id), channel.metadata
    kind = about.get(TYPE) or ("" if schema is None else schema.name)
    return Sample(channel.topic, kind, message.data, message.publish_time, message.log_time, about.get(QOS, ""))
