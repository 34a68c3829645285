"""ROS messages to JSON and back, from the definitions themselves."""

import math
from typing import Any

import numpy as np
import orjson
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovariance
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import BatteryState, RegionOfInterest
from std_msgs.msg import ByteMultiArray, UInt8MultiArray
from unique_identifier_msgs.msg import UUID

from action_tutorials_interfaces.action import ConnectToChargingDock, Fibonacci
from dock_gateway.errors import InvalidField
from dock_gateway.ros.messages import MAX_ERRORS, codec, load_action


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
    with pytest.raises(InvalidField, match="uuid: expected an array of 16 items, got 3"):
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


def test_schemas() -> None:
    schema = codec(BatteryState).schema()
    assert schema["properties"]["power_supply_status"] == {"type": "integer", "minimum": 0, "maximum": 255}
    assert schema["properties"]["voltage"]["type"] == ["number", "null"]
    assert "required" not in schema
    complete = codec(BatteryState).schema(complete=True)
    assert complete["required"] == list(complete["properties"])
    assert complete["properties"]["header"]["properties"]["stamp"]["required"] == ["sec", "nanosec"]


def test_action_types_by_name() -> None:
    assert load_action("action_tutorials_interfaces/action/Fibonacci") is Fibonacci
    for unknown in ("action_tutorials_interfaces/action/Nope", "nope_msgs/action/Nope", "nonsense", ""):
        with pytest.raises(ImportError):
            load_action(unknown)
