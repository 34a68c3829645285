"""Reading recordings, whatever bytes they have: it ends, in bounded memory, and raises nothing."""

import os
import tracemalloc
from pathlib import Path

import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.writer import CompressionType

from robot_io import recording
from robot_io.recording import EVENTS, Sample, event_sample, event_text, read, read_last
from tests.support.odd_recordings import as_file, damaged

CAMERA = "sensor_msgs/msg/CompressedImage"
SAMPLES = [
    *(Sample("/odom", "nav_msgs/msg/Odometry", bytes([each]) * 100, each, each) for each in range(100)),
    *(Sample("/camera", CAMERA, bytes([each]) * 100, each, each) for each in range(100, 110)),
    event_sample(b'{"type": "status"}', 120),
]
COMPRESSIONS = [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]
MB = 1_000_000


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_what_was_written_is_read(tmp_path: Path, compression: CompressionType) -> None:
    path = tmp_path / "goal.mcap"
    path.write_bytes(as_file(SAMPLES, compression))
    assert list(read(path)) == SAMPLES
    assert read_last(path, CAMERA) == SAMPLES[-2]
    assert read_last(path, "sensor_msgs/msg/Image") is None


@given(st.sampled_from(COMPRESSIONS).flatmap(lambda each: damaged(as_file(SAMPLES, each))))
def test_a_damaged_file_is_read_as_far_as_it_can_be(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.mcap"
    path.write_bytes(data)
    assert len(list(read(path))) <= len(SAMPLES)
    found = read_last(path, CAMERA)
    assert found is None or found.kind == CAMERA


def chunk(data: bytes, compression: str, size: int) -> bytes:
    """A file with one chunk, that says of itself what it wants."""
    builder = RecordBuilder()
    Chunk(
        compression=compression,
        data=data,
        message_start_time=0,
        message_end_time=1,
        uncompressed_crc=0,
        uncompressed_size=size,
    ).write(builder)
    return b"\x89MCAP0\r\n" + builder.end()


@pytest.mark.parametrize("says", [0, 1000, 150 * MB, 10**12, 2**64 - 1])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_small_file_does_not_become_a_large_one(tmp_path: Path, compression: str, says: int) -> None:
    """100 kB, or less, that are 400 MB without compression."""
    if compression == "zstd":
        compressor = zstandard.ZstdCompressor().compressobj()
        parts = [compressor.compress(bytes(MB)) for _ in range(400)]
        bomb = b"".join([*parts, compressor.flush()])
    else:
        import lz4.frame

        bomb = lz4.frame.compress(bytes(400 * MB))
    path = tmp_path / "bomb.mcap"
    path.write_bytes(chunk(bomb, compression, says))
    tracemalloc.start()
    try:
        assert list(read(path)) == []
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < recording.MAX_RECORD * 2


def test_a_file_has_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "goal.mcap"
    path.write_bytes(as_file(SAMPLES))
    monkeypatch.setattr(recording, "MAX_MESSAGES", 50)
    assert len(list(read(path))) == 50
    monkeypatch.setattr(recording, "MAX_BYTES", 100)
    assert list(read(path)) == []


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="not a regular file"):
        list(read(tmp_path / "pipe"))
    with pytest.raises(FileNotFoundError):
        list(read(tmp_path / "missing"))


@given(st.binary(max_size=50))
def test_events_are_texts(data: bytes) -> None:
    assert event_text(event_sample(data, 1)) == data
    try:
        event_text(Sample(EVENTS, recording.EVENT, data, 1, 1))
    except ValueError:
        return
    assert data.startswith(recording.CDR)
