"""JSON Schema of messages: what it says beyond the types. What it accepts is tested with the codec."""

from typing import Any

import orjson
import pytest
from geometry_msgs.msg import PoseWithCovariance, Quaternion
from jsonschema import Draft202012Validator
from sensor_msgs.msg import BatteryState, Image, LaserScan
from std_msgs.msg import Empty, Header, Int64, UInt64
from test_msgs.msg import Defaults, MultiNested
from type_description_interfaces.msg import FieldType
from visualization_msgs.msg import InteractiveMarkerUpdate

from dock_gateway.core.errors import InvalidField
from dock_gateway.ros.messages.codec import codec


def properties(message_class: type[Any], *, complete: bool = False) -> dict[str, Any]:
    found: dict[str, Any] = codec(message_class).schema(complete=complete)["properties"]
    return found


def test_what_is_taken_is_partial_and_what_is_written_is_complete() -> None:
    taken, written = codec(BatteryState).schema(), codec(BatteryState).schema(complete=True)
    assert "required" not in taken
    assert written["required"] == list(written["properties"]) == list(taken["properties"])
    assert written["$defs"]["builtin_interfaces.msg.Time"]["required"] == ["sec", "nanosec"]
    assert not list(Draft202012Validator(taken).iter_errors({}))
    assert list(Draft202012Validator(written).iter_errors({}))
    assert list(Draft202012Validator(taken).iter_errors({"volts": 1}))


def test_comments_units_and_defaults() -> None:
    assert properties(BatteryState)["voltage"] == {
        "type": ["number", "null"],
        "format": "float",
        "minimum": -3.4028235e38,
        "maximum": 3.4028235e38,
        "description": "Voltage in Volts (Mandatory)",
        "x-unit": "V",
        "default": None,
    }
    assert properties(LaserScan)["ranges"]["x-unit"] == "m"
    assert "x-unit" not in properties(BatteryState)["location"]
    assert properties(Quaternion)["w"]["default"] == 1.0
    assert properties(Defaults)["int16_value"]["default"] == -1000
    assert "default" not in properties(Defaults, complete=True)["int16_value"]
    assert "default" not in properties(PoseWithCovariance)["covariance"]
    assert codec(Header).schema()["description"].startswith("Standard metadata")


def test_constants_are_choices_and_any_number_stays_valid() -> None:
    status = properties(BatteryState)["power_supply_status"]
    assert status["x-constants"]["CHARGING"] == 1
    assert {"const": 1, "title": "CHARGING"} in status["anyOf"]
    technology = properties(BatteryState)["power_supply_technology"]
    assert {"const": 2, "title": "LION", "description": "Lithium-ion battery"} in technology["anyOf"]
    validator = Draft202012Validator(status)
    for good in (0, 255, "CHARGING", "POWER_SUPPLY_STATUS_CHARGING"):
        assert validator.is_valid(good)
    for bad in (-1, 256, 1.5, "GOOD", None, True):
        assert not validator.is_valid(bad)
    written = properties(BatteryState, complete=True)["power_supply_status"]
    assert (written["type"], written["x-constants"]["FULL"]) == ("integer", 4)


@pytest.mark.parametrize(("message_class", "low"), [(Int64, -(2**63)), (UInt64, 0)])
def test_64_bit_integers(message_class: type[Any], low: int) -> None:
    taken = Draft202012Validator(properties(message_class)["data"])
    written = Draft202012Validator(properties(message_class, complete=True)["data"])
    for value in (low, str(low), 0, "9007199254740992"):
        assert taken.is_valid(value)
    assert not taken.is_valid(low - 1)
    assert not taken.is_valid("1.0")
    assert written.is_valid(2**53 - 1)
    assert written.is_valid(str(2**53))
    assert not written.is_valid(2**53)
    assert taken.is_valid("-1") is (low < 0)


def test_bounds() -> None:
    assert properties(FieldType)["nested_type_name"]["maxLength"] == 255
    assert properties(FieldType, complete=True)["nested_type_name"]["maxLength"] == 255
    assert properties(PoseWithCovariance)["covariance"]["minItems"] == 36
    assert properties(PoseWithCovariance)["covariance"]["maxItems"] == 36
    array, base64 = properties(Image)["data"]["anyOf"]
    assert array["maxItems"] == 1_000_000
    assert base64["contentEncoding"] == "base64"
    # What ROS sends has only the bounds of its definition.
    assert "maxItems" not in properties(Image, complete=True)["data"]
    assert "maxLength" not in properties(Image, complete=True)["encoding"]


def test_messages_inside_of_others_are_written_once() -> None:
    schema = codec(InteractiveMarkerUpdate).schema(complete=True)
    assert len(schema["$defs"]) == 16
    assert orjson.dumps(schema).count(b'"title":"Quaternion"') == 1
    assert len(orjson.dumps(schema)) < 32_000
    assert properties(MultiNested)["array_of_arrays"]["items"] == {"$ref": "#/$defs/test_msgs.msg.Arrays"}


def test_an_empty_message() -> None:
    assert codec(Empty).schema(complete=True)["required"] == []
    assert codec(Empty).schema()["properties"] == {}


@pytest.mark.parametrize(
    "document",
    [
        {"voltage": "12"},
        {"voltage": 1e39},
        {"present": 1},
        {"power_supply_status": "GOOD"},
        {"cell_voltage": [True]},
        {"header": {"stamp": {"nanosec": -1}}},
        {"header": None},
        {"nope": 1},
    ],
)
def test_it_refuses_what_parse_refuses(document: dict[str, Any]) -> None:
    assert not Draft202012Validator(codec(BatteryState).schema()).is_valid(document)
    with pytest.raises(InvalidField):
        codec(BatteryState).parse(document)
