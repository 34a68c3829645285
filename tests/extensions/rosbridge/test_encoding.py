"""Messages as rosbridge writes them, in JSON and in CBOR."""

import array
import math
import struct

import cbor2
import numpy as np
import orjson
import pytest
from builtin_interfaces.msg import Time
from cbor2 import CBORTag
from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Header, String
from test_msgs.msg import Arrays, BasicTypes, UnboundedSequences

from dock_gateway.core.goal import encode
from dock_gateway.extensions.rosbridge.typedefs import definition_texts, message_definitions, service_definitions
from dock_gateway.extensions.rosbridge.values import adapter, cbor_values, json_values, reader
from dock_gateway.ros.messages.codec import codec


def test_bytes_are_base64_and_64_bits_a_number() -> None:
    image = Image(header=Header(stamp=Time(sec=1, nanosec=2), frame_id="eye"), data=array.array("B", [1, 2, 255]))
    document = json_values(image)
    assert document["data"] == "AQL/"
    assert document["header"] == {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "eye"}
    basic = BasicTypes(int64_value=2**60, uint64_value=2**64 - 1, byte_value=b"\x07", float32_value=0.1)
    sent = orjson.loads(encode(json_values(basic)))
    assert (sent["int64_value"], sent["uint64_value"], sent["byte_value"]) == (2**60, 2**64 - 1, 7)
    assert np.float32(sent["float32_value"]) == np.float32(0.1)


@pytest.mark.parametrize("count", [3, 100])
def test_nan_is_null(count: int) -> None:
    scan = LaserScan(ranges=[math.nan, math.inf, 1.5] * count, range_max=math.nan)
    sent = orjson.loads(encode(json_values(scan)))
    assert sent["ranges"] == [None, None, 1.5] * count
    assert sent["range_max"] is None


def test_arrays_of_any_kind() -> None:
    for message in (Arrays(), UnboundedSequences(byte_values=[b"\x01"], string_values=["a"], bool_values=[True])):
        orjson.loads(encode(json_values(message)))
        cbor2.dumps(cbor_values(message))


def test_typed_arrays_in_cbor() -> None:
    scan = cbor_values(LaserScan(ranges=[1.0, 2.0]))
    assert scan["ranges"] == CBORTag(85, struct.pack("<2f", 1.0, 2.0))
    assert cbor_values(Image(data=array.array("B", [1, 2])))["data"] == b"\x01\x02"


def test_the_json_of_the_gateway_is_adapted() -> None:
    assert adapter(String) is None
    message = UnboundedSequences(
        uint8_values=array.array("B", [1, 2, 255]),
        int64_values=array.array("q", [2**60]),
        basic_types_values=[BasicTypes(uint64_value=2**63)],
    )
    adapt = adapter(UnboundedSequences)
    assert adapt is not None
    adapted = adapt(orjson.loads(codec(UnboundedSequences).encode(message)))
    assert adapted["uint8_values"] == "AQL/"
    assert adapted["int64_values"] == [2**60]
    assert adapted["basic_types_values"][0]["uint64_value"] == 2**63


def test_times_of_ros_1_are_read() -> None:
    assert reader(String) is None
    read = reader(PoseArray)
    assert read is not None
    assert read({"header": {"stamp": {"secs": 1, "nsecs": 2}}}) == {"header": {"stamp": {"sec": 1, "nanosec": 2}}}
    assert read({"header": {"stamp": "now"}})["header"]["stamp"]["sec"] > 1_700_000_000
    for wrong in (None, 7, {"header": 7}, {"header": {"stamp": {"secs": 1}}}, {"poses": 7}, {"other": [[]]}):
        assert read(wrong) == wrong


def test_definitions() -> None:
    header, stamp = message_definitions("std_msgs/Header")
    assert (header["type"], header["fieldnames"]) == ("std_msgs/Header", ["stamp", "frame_id"])
    assert header["fieldtypes"] == ["builtin_interfaces/Time", "string"]
    assert stamp["fieldtypes"] == ["int32", "uint32"]
    (image, *_) = message_definitions("sensor_msgs/msg/Image")
    assert dict(zip(image["fieldnames"], image["fieldarraylen"], strict=True))["data"] == 0
    (request,) = service_definitions("std_srvs/SetBool", "Request")
    assert request["fieldnames"] == ["data"]
    assert "MSG: builtin_interfaces/Time" in definition_texts("std_msgs/msg/Header")
    assert definition_texts("nothing_msgs/msg/Nothing") == ""
