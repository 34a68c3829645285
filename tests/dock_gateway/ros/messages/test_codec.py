"""ROS messages to JSON and back, from the definitions themselves."""

import importlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovariance
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from nav_msgs.msg import OccupancyGrid
from rcl_interfaces.msg import ParameterDescriptor, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import BatteryState, Image, JoyFeedback, NavSatStatus, PointField, RegionOfInterest
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import ByteMultiArray, Char, Empty, Int64, UInt8MultiArray, UInt64, UInt64MultiArray
from test_msgs.action import NestedMessage
from test_msgs.msg import Defaults, MultiNested, WStrings
from type_description_interfaces.msg import FieldType
from unique_identifier_msgs.msg import UUID

from action_tutorials_interfaces.action import ConnectToChargingDock, Fibonacci
from dock_gateway.core.errors import InvalidField
from dock_gateway.core.json_text import Infinite
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.fields import MAX_ERRORS
from tests.support.messages import alike, documents


def round_trip(message_class: type[Any], value: dict[str, Any]) -> Any:
    return orjson.loads(codec(message_class).encode(codec(message_class).parse(value)))


@given(st.floats(width=32, allow_infinity=False))
def test_float32_is_written_as_its_shortest_text_and_read_back_exactly(number: float) -> None:
    text = codec(BatteryState).encode(codec(BatteryState).parse({"voltage": None if math.isnan(number) else number}))
    value = orjson.loads(text)["voltage"]
    if math.isnan(number):
        assert value is None
    else:
        assert np.float32(value) == np.float32(number)
        assert len(str(abs(value))) <= len(str(abs(number)))


def test_the_tutorials_battery() -> None:
    value = round_trip(BatteryState, {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3})
    assert (value["voltage"], value["percentage"], value["power_supply_status"]) == (2.16, 0.24, 3)
    assert value["temperature"] is None
    assert value["present"] is False
    assert value["cell_voltage"] == []


def test_unset_floats_are_nan_where_the_message_asks_for_it_also_inside_another() -> None:
    goal = codec(ConnectToChargingDock.Goal).parse({})
    assert math.isnan(goal.desired_battery_state.voltage)
    pose = codec(PoseWithCovariance).parse({})
    assert pose.pose.orientation.w == 1.0
    assert pose.pose.position.x == 0.0


def test_the_largest_float32_goes_there_and_back() -> None:
    largest = float(np.finfo(np.float32).max)
    value = round_trip(BatteryState, {"voltage": largest, "cell_voltage": [-largest]})
    assert value["voltage"] == 3.4028235e38
    message = through_cdr(codec(BatteryState).parse(value))
    assert (message.voltage, list(message.cell_voltage)) == (largest, [-largest])


def test_infinity_from_ros_is_null() -> None:
    assert orjson.loads(codec(BatteryState).encode(BatteryState(voltage=math.inf)))["voltage"] is None


@pytest.mark.parametrize(
    ("message_class", "value"),
    [
        (Fibonacci.Result, {"sequence": [0, 1, -2, 2**31 - 1]}),
        (UUID, {"uuid": list(range(16))}),
        (ByteMultiArray, {"layout": {"dim": [], "data_offset": 0}, "data": [0, 255]}),
        (UInt8MultiArray, {"layout": {"dim": [{"label": "é", "size": 1, "stride": 2}], "data_offset": 3}, "data": [7]}),
        (RegionOfInterest, {"x_offset": 1, "y_offset": 2, "height": 3, "width": 4, "do_rectify": True}),
        (KeyValue, {"key": "a", "value": "ü\U0001f50b"}),
    ],
)
def test_all_kinds_of_fields(message_class: type[Any], value: dict[str, Any]) -> None:
    assert round_trip(message_class, value) == value


def test_nested_messages_and_octets() -> None:
    message = DiagnosticArray(status=[DiagnosticStatus(level=b"\x02", name="n", values=[KeyValue(key="k", value="v")])])
    status = orjson.loads(codec(DiagnosticArray).encode(message))["status"][0]
    assert status["level"] == 2
    assert status["values"] == [{"key": "k", "value": "v"}]
    assert codec(DiagnosticStatus).parse({"level": 2}).level == b"\x02"


def test_fixed_arrays_have_their_length() -> None:
    with pytest.raises(InvalidField, match="uuid: expected an array of 16 items, or base64, got 3"):
        codec(UUID).parse({"uuid": [1, 2, 3]})
    assert len(codec(PoseWithCovariance).parse({"covariance": [0.5] * 36}).covariance) == 36


def test_everything_that_is_wrong_is_said_up_to_a_limit() -> None:
    with pytest.raises(InvalidField) as refused:
        codec(BatteryState).parse({"voltage": "x", "present": 1, "header": {"stamp": {"sec": None}}})
    assert [error["path"] for error in refused.value.extra["errors"]] == ["voltage", "present", "header.stamp.sec"]
    with pytest.raises(InvalidField) as refused:
        codec(BatteryState).parse({"cell_voltage": ["x"] * 1000})
    assert len(refused.value.extra["errors"]) == MAX_ERRORS


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    )
)
def test_any_json_is_a_message_or_a_clear_error(value: Any) -> None:
    refusals: list[Any] = []
    for field in ("header", "voltage", "power_supply_status", "present", "cell_voltage", "location"):
        try:
            message = codec(BatteryState).parse({field: value})
        except InvalidField as error:
            refusals.append(error.extra["errors"])
        else:
            assert orjson.loads(codec(BatteryState).encode(message))
    assert all(refusals)


PACKAGES = (
    *("diagnostic_msgs", "geometry_msgs", "nav_msgs", "sensor_msgs", "shape_msgs", "std_msgs", "test_msgs"),
    *("trajectory_msgs", "visualization_msgs", "rcl_interfaces", "type_description_interfaces", "action_msgs"),
)
EVERY_MESSAGE = [
    message_class
    for package in PACKAGES
    for message_class in vars(importlib.import_module(f"{package}.msg")).values()
    if hasattr(message_class, "SLOT_TYPES")
]
ACTIONS = [ConnectToChargingDock, Fibonacci, NestedMessage]
EVERY_MESSAGE += [part for action in ACTIONS for part in (action.Goal, action.Result, action.Feedback)]


def through_cdr(message: Any) -> Any:
    return deserialize_message(serialize_message(message), type(message))


def errors_of(message_class: type[Any], value: Any) -> list[str]:
    with pytest.raises(InvalidField) as refused:
        codec(message_class).parse(value)
    return [f"{error['path']}: {error['expected']}, {error['detail']}" for error in refused.value.extra["errors"]]


@pytest.mark.parametrize("message_class", EVERY_MESSAGE, ids=lambda message_class: message_class.__name__)
def test_any_message_to_cdr_and_back_within_its_schemas(message_class: type[Any]) -> None:
    compiled = codec(message_class)
    takes, writes = Draft202012Validator(compiled.schema()), Draft202012Validator(compiled.schema(complete=True))
    for validator in (takes, writes):
        validator.check_schema(validator.schema)

    @settings(max_examples=8, suppress_health_check=list(HealthCheck))
    @given(documents(message_class))
    def round_trips(document: dict[str, Any]) -> None:
        takes.validate(document)
        message = compiled.parse(document)
        received = through_cdr(message)
        assert alike(received, message)
        text = compiled.encode(received)
        writes.validate(orjson.loads(text))
        assert alike(through_cdr(compiled.parse(orjson.loads(text))), received)

    round_trips()


def test_an_empty_message() -> None:
    assert codec(Empty).encode(codec(Empty).parse({})) == b"{}"
    assert errors_of(Empty, {"data": 1}) == ["data: no fields, got an unknown field"]


def test_defaults_of_the_definition_stay_where_nothing_is_given() -> None:
    assert alike(codec(Defaults).parse({}), Defaults())
    assert round_trip(Defaults, {"int8_value": 1})["uint64_value"] == 50000000


@pytest.mark.parametrize("message_class", [Int64, UInt64])
def test_integers_that_a_double_cannot_hold_are_strings_and_taken_both_ways(message_class: type[Any]) -> None:
    safe, high = 2**53 - 1, 2**63 - 1
    assert round_trip(message_class, {"data": safe}) == {"data": safe}
    for given_as in (safe + 1, str(safe + 1)):
        assert round_trip(message_class, {"data": given_as}) == {"data": "9007199254740992"}
    assert codec(message_class).parse({"data": str(high)}).data == high
    for text in ("", "1.0", "1e3", " 1", "0x1", "\u0661", "007", str(2**64), "9" * 100):
        (error,) = errors_of(message_class, {"data": text})
        assert error.startswith("data: ")
        assert error.endswith(f"as a number or a decimal string), got {text[:40]!r}")
    assert errors_of(UInt64, {"data": "-1"})
    assert codec(Int64).parse({"data": str(-(2**63))}).data == -(2**63)
    assert round_trip(Int64, {"data": -(2**53)}) == {"data": str(-(2**53))}


@pytest.mark.parametrize("count", [2, 100])
def test_arrays_of_64_bit_integers(count: int) -> None:
    numbers = [0, 2**64 - 1] * (count // 2)
    assert round_trip(UInt64MultiArray, {"data": numbers})["data"] == [0, "18446744073709551615"] * (count // 2)
    assert round_trip(UInt64MultiArray, {"data": [str(number) for number in numbers]})["data"][1] == str(2**64 - 1)
    assert round_trip(UInt64MultiArray, {"data": [5] * count})["data"] == [5] * count


def test_bytes_as_numbers_and_as_base64() -> None:
    assert bytes(codec(Image).parse({"data": "AAH/"}).data) == b"\x00\x01\xff"
    assert codec(ByteMultiArray).parse({"data": "AAH/"}).data == [b"\x00", b"\x01", b"\xff"]
    assert round_trip(UUID, {"uuid": "AAECAwQFBgcICQoLDA0ODw=="}) == {"uuid": list(range(16))}
    assert len(codec(Image).parse({"data": [7] * 200_000}).data) == 200_000
    assert errors_of(UUID, {"uuid": "AAEC"}) == ["uuid: an array of 16 items, or base64, got 3"]
    for text in ("A", "AAEC\n", "é", "-_-_"):
        (error,) = errors_of(Image, {"data": text})
        assert "got a string that is not base64" in error
    assert errors_of(OccupancyGrid, {"data": "AAEC"}) == ["data: an array of at most 10000 items, got a string"]


def test_a_whole_number_is_an_integer_however_it_is_written() -> None:
    state = codec(BatteryState).parse({"power_supply_status": 1.0})
    assert (state.power_supply_status, type(state.power_supply_status)) == (1, int)
    assert list(codec(Image).parse({"data": [0, 255.0, 7]}).data) == [0, 255, 7]
    assert errors_of(BatteryState, {"power_supply_status": 256.0})


def test_numbers_of_an_array_are_looked_at_one_by_one_where_one_is_wrong() -> None:
    assert errors_of(Image, {"data": [0, 256, True, 1.5, 1.0]}) == [
        "data.1: uint8 (0 to 255), got 256",
        "data.2: uint8 (0 to 255), got a boolean",
        "data.3: uint8 (0 to 255), got 1.5",
    ]
    assert errors_of(BatteryState, {"cell_voltage": [1.0, 1e39]}) == [
        "cell_voltage.1: float32 (-3.4e38 to 3.4e38) or null, got 1e+39"
    ]
    assert errors_of(SolidPrimitive, {"dimensions": [math.inf]}) == ["dimensions.0: float64 or null, got inf"]
    assert list(codec(SolidPrimitive).parse({"dimensions": [Infinite("-inf"), 1, Infinite("inf")]}).dimensions) == [
        -math.inf,
        1.0,
        math.inf,
    ]
    assert codec(BatteryState).parse({"voltage": Infinite("inf")}).voltage == math.inf
    assert errors_of(BatteryState, {"power_supply_status": Infinite("inf"), "present": Infinite("inf")})
    assert [math.isnan(volts) for volts in codec(BatteryState).parse({"cell_voltage": [None, 4]}).cell_voltage] == [
        True,
        False,
    ]


def test_bounds() -> None:
    assert errors_of(SolidPrimitive, {"dimensions": [1.0] * 4}) == ["dimensions: an array of at most 3 items, got 4"]
    assert errors_of(FieldType, {"nested_type_name": "x" * 256}) == [
        "nested_type_name: a string of at most 255 characters, got 256"
    ]
    assert errors_of(ParameterDescriptor, {"integer_range": [{}, {"step": -1}]}) == [
        "integer_range: an array of at most 1 items, got 2"
    ]
    (error,) = errors_of(ParameterDescriptor, {"integer_range": [{"step": -1}]})
    assert error.startswith("integer_range.0.step: uint64 (0 to 18446744073709551615")
    assert errors_of(WStrings, {"wstring_value": "a\0b"}) == ["wstring_value: a string without NUL characters, got one"]


def test_char_octet_and_wide_strings() -> None:
    assert round_trip(Char, {"data": 255}) == {"data": 255}
    assert round_trip(ParameterValue, {"byte_array_value": [1, 2]})["byte_array_value"] == [1, 2]
    assert round_trip(WStrings, {"wstring_value": "ハローワールド"})["wstring_value"] == "ハローワールド"


def test_deep_nesting_names_the_whole_path() -> None:
    value = {"unbounded_sequence_of_unbounded_sequences": [{}, {"basic_types_values": [{"int8_value": 128}]}]}
    assert errors_of(MultiNested, value) == [
        "unbounded_sequence_of_unbounded_sequences.1.basic_types_values.0.int8_value: int8 (-128 to 127), got 128"
    ]


@pytest.mark.parametrize("name", ["CHARGING", "charging", "Charging", "POWER_SUPPLY_STATUS_CHARGING"])
def test_constants_by_name(name: str) -> None:
    message = codec(ConnectToChargingDock.Goal).parse({"desired_battery_state": {"power_supply_status": name}})
    assert message.desired_battery_state.power_supply_status == 1


def test_a_name_that_is_none_of_the_constants() -> None:
    path = "desired_battery_state.power_supply_status"
    for name in ("GOOD", "STATUS_CHARGING", "1", ""):
        assert errors_of(ConnectToChargingDock.Goal, {"desired_battery_state": {"power_supply_status": name}}) == [
            f"{path}: uint8 (0 to 255) or one of UNKNOWN, CHARGING, DISCHARGING, NOT_CHARGING, FULL, got {name!r}"
        ]


def test_constants_belong_to_the_field_they_are_named_after_and_nothing_is_guessed() -> None:
    assert codec(NavSatStatus).parse({"status": "no_fix", "service": "GALILEO"}).status == -1
    assert codec(JoyFeedback).parse({"type": "RUMBLE"}).type == 1
    assert errors_of(NavSatStatus, {"service": "NO_FIX"})
    assert errors_of(NavSatStatus, {"status": "_DEFAULT"})
    assert errors_of(JoyFeedback, {"id": "RUMBLE"}) == ["id: uint8 (0 to 255), got a string"]
    assert errors_of(PointField, {"datatype": "UINT8"}) == ["datatype: uint8 (0 to 255), got a string"]
    assert errors_of(DiagnosticStatus, {"level": "WARN"}) == ["level: octet (0 to 255), got a string"]


def test_the_compiled_code_and_a_field_called_m() -> None:
    inertia = importlib.import_module("geometry_msgs.msg").Inertia
    assert round_trip(inertia, {"m": 2.5})["m"] == 2.5
    assert Path(codec(inertia).document.__code__.co_filename).name == "<string>"
