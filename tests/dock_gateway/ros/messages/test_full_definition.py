"""Whole definitions, as recordings and viewers need them."""

import pytest
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool
from test_msgs.msg import Arrays, BasicTypes, BoundedSequences

from action_tutorials_interfaces.action import ConnectToChargingDock
from dock_gateway.ros.messages import full_definition as module
from dock_gateway.ros.messages.full_definition import SEPARATOR, full_definition


def parts(text: str) -> dict[str, list[str]]:
    """Return the lines of each type without comments; those of the type itself under an empty name."""
    own, *others = text.split(f"{SEPARATOR}\nMSG: ")
    named = {"": own} | dict(other.split("\n", 1) for other in others)
    return {
        name: [line.split("#")[0].strip() for line in each.splitlines() if line.split("#")[0].strip()]
        for name, each in named.items()
    }


def test_each_type_of_a_message_is_there_once() -> None:
    odometry = parts(full_definition(Odometry))
    assert odometry["geometry_msgs/PoseWithCovariance"] == ["Pose pose", "float64[36] covariance"]
    assert {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Vector3"} < set(odometry)
    assert full_definition(Odometry).count("MSG: geometry_msgs/Vector3\n") == 1


def test_the_feedback_of_an_action() -> None:
    feedback = parts(full_definition(ConnectToChargingDock.Impl.FeedbackMessage))
    assert feedback[""] == [
        "unique_identifier_msgs/UUID goal_id",
        "action_tutorials_interfaces/ConnectToChargingDock_Feedback feedback",
    ]
    assert feedback["action_tutorials_interfaces/ConnectToChargingDock_Feedback"] == [
        "sensor_msgs/BatteryState current_battery_state"
    ]
    assert "uint8[16] uuid" in feedback["unique_identifier_msgs/UUID"]


def test_the_parts_of_a_service() -> None:
    assert parts(full_definition(SetBool.Request))[""] == ["bool data"]
    assert parts(full_definition(SetBool.Response))[""] == ["bool success", "string message"]


def test_without_its_file_a_type_is_written_from_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "definition_text", lambda *_: None)
    full_definition.cache_clear()
    try:
        basic = parts(full_definition(BasicTypes))[""]
        assert {"bool bool_value", "byte byte_value", "float32 float32_value", "int64 int64_value"} < set(basic)
        arrays = parts(full_definition(Arrays))
        assert "float64[3] float64_values" in arrays[""]
        assert "test_msgs/BasicTypes[3] basic_types_values" in arrays[""]
        assert "int8[<=3] int8_values" in parts(full_definition(BoundedSequences))[""]
    finally:
        full_definition.cache_clear()
