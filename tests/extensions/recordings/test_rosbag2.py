"""Recordings follow rosbag2's rules, as its sources have them, and the library rosbags reads every message."""

from pathlib import Path

import pytest
import yaml
from geometry_msgs.msg import Twist
from mcap.reader import make_reader
from mcap.records import Schema
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import LaserScan

from action_tutorials_interfaces.action import ConnectToChargingDock
from dock_gateway.extensions.recordings.mcap_file import McapFile
from dock_gateway.extensions.recordings.offered_qos import offered_qos
from dock_gateway.ros.messages.interfaces import load_message
from robot_io.recording import EVENTS, Sample, event_sample, read
from tf2_msgs.msg import TFMessage

FEEDBACK = "action_tutorials_interfaces/action/ConnectToChargingDock_FeedbackMessage"
LATCHED = {"/tf_static", "/map"}
S = 1_000_000_000


def sample(topic: str, kind: str, message: object, at: float, qos: str) -> Sample:
    return Sample(topic, kind, serialize_message(message), round(at * S), round(at * S), qos)


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "goal.mcap"
    sensor, latched = offered_qos(reliable=False, kept=0), offered_qos(reliable=True, kept=1)
    plain = offered_qos(reliable=True, kept=0)
    feedback = ConnectToChargingDock.Impl.FeedbackMessage()
    with path.open("wb") as output:
        file = McapFile(output)
        file.write(
            [
                sample("/tf_static", "tf2_msgs/msg/TFMessage", TFMessage(), 10, latched),
                sample("/map", "nav_msgs/msg/OccupancyGrid", OccupancyGrid(data=[1, 2]), 10, latched),
                sample("/scan", "sensor_msgs/msg/LaserScan", LaserScan(ranges=[1.0]), 10, sensor),
                event_sample(b'{"type": "status"}', 11 * S),
            ]
        )
        file.write(
            [
                sample("/cmd_vel", "geometry_msgs/msg/Twist", Twist(), 12, plain),
                sample("/dock/_action/feedback", FEEDBACK, feedback, 13, plain),
            ]
        )
        file.finish({"goal_id": "g1"})
    return path


def test_rosbag2_opens_it(recording: Path) -> None:
    """What rosbag2 0.26.5 (Jazzy) asks of a file; Kilted and Rolling ask the same.

    - All topics have the encoding of the first one, or "All topics must have the same serialization format" is thrown:
      rosbag2_cpp/src/rosbag2_cpp/readers/sequential_reader.cpp, `check_topics_serialization_formats`. It is `cdr`, or a
      converter is looked for.
    - The summary has a statistics record, and each channel a schema: rosbag2_storage_mcap/src/mcap_storage.cpp,
      `read_metadata`. The schema's name is the topic's type.
    - Chunks have message indexes, or messages come in the order of the file: the same, `set_read_order`.
    - `offered_qos_profiles` is a YAML sequence; policies are numbers up to version 8 of the metadata, then words, and
      newer readers see which: rosbag2_storage/src/rosbag2_storage/qos.cpp, `convert<rclcpp::QoS>::decode`. Without it a
      topic is published as volatile.
    """
    with recording.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert (summary.statistics.message_count, summary.statistics.message_start_time) == (6, 10 * S)
    assert all(index.message_index_length > 0 for index in summary.chunk_indexes)
    channels = {channel.topic: channel for channel in summary.channels.values()}
    assert {channel.message_encoding for channel in channels.values()} == {"cdr"}
    assert len(channels) == len(summary.channels), "a topic is there once"
    for channel in channels.values():
        schema = summary.schemas[channel.schema_id]
        assert isinstance(schema, Schema)
        assert schema.encoding == "ros2msg"
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        if "_action" not in channel.topic:  # its name has no `_`, so that rosbag2 leaves it out when it plays
            assert load_message(schema.name)
    for topic in channels.keys() - {EVENTS}:
        (profile,) = yaml.safe_load(channels[topic].metadata["offered_qos_profiles"])
        assert profile.keys() == {
            "history",
            "depth",
            "reliability",
            "durability",
            "deadline",
            "lifespan",
            "liveliness",
            "liveliness_lease_duration",
            "avoid_ros_namespace_conventions",
        }
        durability = DurabilityPolicy.TRANSIENT_LOCAL if topic in LATCHED else DurabilityPolicy.VOLATILE
        reliability = ReliabilityPolicy.BEST_EFFORT if topic == "/scan" else ReliabilityPolicy.RELIABLE
        assert (profile["durability"], profile["reliability"]) == (durability.value, reliability.value)


def test_rosbags_reads_each_message(recording: Path) -> None:
    """Types come from the file alone, but for those of the distribution."""
    found = {}
    with AnyReader([recording], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection in reader.connections:
            (qos,) = connection.ext.offered_qos_profiles or [None]  # type: ignore[union-attr]
            assert connection.topic == EVENTS or qos is not None
            if qos is not None:
                assert (qos.durability is QosDurability.TRANSIENT_LOCAL) == (connection.topic in LATCHED)
                assert (qos.reliability is QosReliability.BEST_EFFORT) == (connection.topic == "/scan")
        for connection, at, data in reader.messages():
            found[connection.topic] = (at // S, reader.deserialize(data, connection.msgtype))
    assert list(found)[:2] == ["/tf_static", "/map"], "what holds comes first"
    assert {topic: at for topic, (at, _) in found.items()} == {
        "/tf_static": 10,
        "/map": 10,
        "/scan": 10,
        EVENTS: 11,
        "/cmd_vel": 12,
        "/dock/_action/feedback": 13,
    }
    assert list(found["/map"][1].data) == [1, 2]
    assert found[EVENTS][1].data == '{"type": "status"}'


def test_a_copy_says_the_same_of_its_topics(recording: Path, tmp_path: Path) -> None:
    """As when a goal goes on after a restart, or someone gets a part of a recording."""
    samples = list(read(recording))
    with (tmp_path / "copy.mcap").open("wb") as output:
        file = McapFile(output)
        file.write(samples)
        file.finish({})
    assert list(read(tmp_path / "copy.mcap")) == samples
    assert {each.qos for each in samples if each.topic in LATCHED} == {offered_qos(reliable=True, kept=1)}


def test_a_topic_has_one_type_and_what_is_not_installed_is_left_out(tmp_path: Path) -> None:
    """rosbag2 publishes all messages of a topic with the type of one."""
    twist = sample("/a", "geometry_msgs/msg/Twist", Twist(), 1, "")
    path = tmp_path / "goal.mcap"
    with path.open("wb") as output:
        McapFile(output).write(
            [
                twist,
                Sample("/a", "nav_msgs/msg/OccupancyGrid", b"", 2, 2),
                Sample("/b", "missing_msgs/msg/Missing", b"", 3, 3),
                Sample("/c", "no type", b"", 3, 3),
                twist._replace(received_ns=4),
            ]
        )
    assert [(each.topic, each.received_ns) for each in read(path)] == [("/a", S), ("/a", 4)]
