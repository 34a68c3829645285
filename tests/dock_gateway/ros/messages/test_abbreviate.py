"""Messages cut down to what a person looks at."""

import array
from typing import Any

import orjson
from geometry_msgs.msg import Point, PoseWithCovariance
from rcl_interfaces.msg import ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import BatteryState, Image, LaserScan
from std_msgs.msg import String
from test_msgs.msg import Arrays, Nested, Strings
from visualization_msgs.msg import Marker, MarkerArray

from action_tutorials_interfaces.action import Fibonacci
from dock_gateway.ros.messages.abbreviate import abbreviate
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.raw_port import EchoType


def heard(message: Any) -> Any:
    """The message as it comes off the wire."""
    return deserialize_message(serialize_message(message), type(message))


def cut(message: Any) -> tuple[Any, dict[str, int]]:
    message = heard(message)
    lengths = abbreviate(message)
    return orjson.loads(codec(type(message)).encode(message)), lengths


def test_numbers() -> None:
    document, lengths = cut(LaserScan(ranges=array.array("f", range(101)), intensities=array.array("f", range(100))))
    assert lengths == {"ranges": 101}
    assert document["ranges"] == list(range(100))
    assert len(document["intensities"]) == 100


def test_bytes() -> None:
    document, lengths = cut(Image(data=array.array("B", bytes(1_000_000)), encoding="mono8"))
    assert lengths == {"data": 1_000_000}
    assert document["data"] == [0] * 100


def test_texts() -> None:
    assert cut(String(data="é" * 10_000))[1] == {}
    document, lengths = cut(String(data="é" * 10_001))
    assert lengths == {"data": 10_001}
    assert document["data"] == "é" * 10_000


def test_messages_inside_of_messages() -> None:
    markers = [Marker(ns=str(index), points=[Point(x=1.0)] * (150 if index == 3 else 1)) for index in range(120)]
    document, lengths = cut(MarkerArray(markers=markers))
    assert lengths == {"markers": 120, "markers.3.points": 150}
    assert len(document["markers"]) == 100
    assert len(document["markers"][3]["points"]) == 100
    assert document["markers"][99]["ns"] == "99"


def test_texts_inside_of_arrays() -> None:
    event = ParameterEvent()
    value = ParameterValue(string_array_value=["short", "x" * 20_000])
    document, lengths = cut(value)
    assert lengths == {"string_array_value.1": 20_000}
    assert document["string_array_value"] == ["short", "x" * 10_000]
    assert cut(event)[1] == {}


def test_what_is_short_stays_as_it_is() -> None:
    for message in (
        PoseWithCovariance(),
        BatteryState(cell_voltage=array.array("f", [1.0])),
        Arrays(),
        Nested(),
        Strings(),
    ):
        before = codec(type(message)).encode(heard(message))
        whole = heard(message)
        assert abbreviate(whole) == {}
        assert codec(type(message)).encode(whole) == before


def test_a_type_reads_what_was_heard() -> None:
    kind = EchoType("sensor_msgs/msg/LaserScan")
    assert (kind.installed, kind.hint) == (True, None)
    document, lengths, _ = kind.read(serialize_message(LaserScan(ranges=array.array("f", range(500)))))
    assert lengths == {"ranges": 500}
    assert len(orjson.loads(document)["ranges"]) == 100


def test_the_feedback_of_an_action_is_a_type() -> None:
    kind = EchoType("action_tutorials_interfaces/action/Fibonacci_FeedbackMessage")
    message = Fibonacci.Impl.FeedbackMessage(feedback=Fibonacci.Feedback(partial_sequence=[1, 2]))
    assert orjson.loads(kind.read(serialize_message(message)).message)["feedback"] == {"partial_sequence": [1, 2]}


def test_a_type_that_is_not_installed_says_what_to_install() -> None:
    kind = EchoType("lift_msgs/msg/LiftState")
    assert not kind.installed
    assert kind.hint is not None
    assert "install the Python package of the ROS interfaces lift_msgs" in kind.hint
