"""Interface packages by name, and `/interfaces`."""

import sys
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from starlette.testclient import TestClient
from std_msgs.msg import String
from test_msgs.action import NestedMessage

from action_tutorials_interfaces.action import Fibonacci
from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.ros.messages.interfaces import (
    definition_text,
    install_hint,
    is_installed,
    known_actions,
    load_action,
    load_message,
)
from dock_gateway.settings import Settings
from tests.support.history import HistoryInMemory

HINT = "install the Python package of the ROS interfaces lift_msgs (such as ros-kilted-lift-msgs)"
DOCK = "action_tutorials_interfaces/action/ConnectToChargingDock"


@pytest.fixture(scope="module")
def client() -> TestClient:
    client = TestClient(create_app(Settings()), base_url="http://127.0.0.1:8000")  # no lifespan: no ROS
    settings = Settings()
    client.app_state["parts"] = Parts({Settings: settings, Logins: Logins(HistoryInMemory()), Quotas: Quotas(settings)})
    return client


def test_action_types_by_name() -> None:
    assert load_action("action_tutorials_interfaces/action/Fibonacci") is Fibonacci
    assert load_action("test_msgs/action/NestedMessage") is NestedMessage


@pytest.mark.parametrize(
    ("type_name", "message"),
    [
        ("action_tutorials_interfaces/action/Nope", "have no action Nope"),
        ("sensor_msgs/action/BatteryState", "have no action BatteryState"),
        ("test_msgs/action/Fibonacci_GetResult_Request", "is not an action type"),
        ("slam_msgs/action/MakeMap", "install the Python package of the ROS interfaces slam_msgs"),
        ("antigravity/action/Nope", "is not installed"),
        ("os/action/Path", "is not installed"),
        ("dock_gateway/action/Nope", "is not installed"),
        ("a.b/action/C", "is not an action type"),
        ("../x/action/C", "is not an action type"),
        ("test_msgs/msg/Empty", "is not an action type"),
        ("test_msgs/action/Fibonacci\n", "is not an action type"),
        ("nonsense", "is not an action type"),
        ("", "is not an action type"),
    ],
)
def test_names_that_are_no_action_type(type_name: str, message: str) -> None:
    with pytest.raises(ImportError, match=message):
        load_action(type_name)


@pytest.mark.parametrize("line", ["raise RuntimeError('built for another Python')", "raise SystemExit(3)", "def"])
def test_a_package_that_fails_when_it_is_imported(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "broken_msgs"
    for file in ("__init__.py", "broken_msgs_s__rosidl_typesupport_c.so", "action/__init__.py"):
        package.joinpath(file).parent.mkdir(parents=True, exist_ok=True)
        package.joinpath(file).write_text(line if "action" in file else "")
    monkeypatch.syspath_prepend(tmp_path)
    for _ in range(2):
        with pytest.raises(ImportError, match=r"broken_msgs\.action cannot be imported"):
            load_action("broken_msgs/action/Broken")
    for name in [name for name in sys.modules if name.startswith("broken_msgs")]:
        del sys.modules[name]


def test_message_types_by_name() -> None:
    assert load_message("std_msgs/msg/String") is String
    assert load_message("test_msgs/action/NestedMessage_FeedbackMessage") is NestedMessage.Impl.FeedbackMessage


@pytest.mark.parametrize(
    ("type_name", "message"),
    [
        ("std_msgs/msg/Nope", "have no message Nope"),
        ("test_msgs/action/Nope_FeedbackMessage", "have no action Nope"),
        ("lift_msgs/msg/LiftState", "install the Python package of the ROS interfaces lift_msgs"),
        ("test_msgs/srv/Empty_Event", "is not a message type"),
        ("test_msgs/action/NestedMessage_Feedback", "is not a message type"),
        ("std_msgs::msg::dds_::String_", "is not a message type"),
        ("os/msg/path", "is not a message type"),
        ("os/msg/Path", "is not installed"),
        ("", "is not a message type"),
    ],
)
def test_names_that_are_no_message_type(type_name: str, message: str) -> None:
    with pytest.raises(ImportError, match=message):
        load_message(type_name)


def test_nothing_is_imported_but_what_rosidl_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "trap"
    package.joinpath("action").mkdir(parents=True)
    for folder in (package, package / "action"):
        folder.joinpath("__init__.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    assert not is_installed("trap")
    with pytest.raises(ImportError, match="is not installed"):
        load_action("trap/action/Nope")
    assert "trap" not in sys.modules
    assert not is_installed("__main__")
    assert not is_installed("antigravity")
    assert is_installed("sensor_msgs")


def test_the_ament_index_and_definitions_of_sourced_workspaces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    index = tmp_path / "share/ament_index/resource_index/rosidl_interfaces"
    index.mkdir(parents=True)
    index.joinpath("lift_msgs").write_text("action/Ride.action\naction/Ride.idl\nmsg/Floor.msg\naction/bad name.idl")
    definition = tmp_path / "share/lift_msgs/action/Ride.action"
    definition.parent.mkdir(parents=True)
    definition.write_text("int32 floor")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}:")
    monkeypatch.setenv("ROS_DISTRO", "kilted")
    assert "lift_msgs/action/Ride" in known_actions()
    assert DOCK in known_actions()
    assert definition_text("lift_msgs", "action", "Ride") == "int32 floor"
    assert definition_text("lift_msgs", "action", "Fall") is None
    assert install_hint("lift_msgs") == HINT


def test_every_interface_is_listed_and_found(client: TestClient) -> None:
    interfaces = client.get("/interfaces").json()["interfaces"]
    assert DOCK in [entry["type"] for entry in interfaces]
    for entry in interfaces:
        assert entry["installed"] is (entry["hint"] is None)
        if not entry["installed"]:
            continue
        document = client.get(entry["schema_path"]).json()
        assert document["type"] == entry["type"]
        for part in ("goal", "result", "feedback"):
            assert document[part]["$schema"] == Draft202012Validator.META_SCHEMA["$id"]
            Draft202012Validator.check_schema(document[part])


def test_the_docking_action(client: TestClient) -> None:
    answer = client.get(f"/interfaces/{DOCK}")
    assert answer.headers["content-type"] == "application/json"
    document = answer.json()
    goal = Draft202012Validator(document["goal"])
    assert goal.is_valid({})
    assert goal.is_valid({"desired_battery_state": {"power_supply_status": "CHARGING"}})
    assert not goal.is_valid({"desired_battery_state": {"power_supply_status": 256}})
    assert document["feedback"]["required"] == ["current_battery_state"]
    assert document["result"]["$defs"]["sensor_msgs.msg.BatteryState"]["properties"]["current"]["x-unit"] == "A"


@pytest.mark.parametrize("name", ["Fibonacci", "ConnectToChargingDock", "DisconnectFromChargingDock"])
def test_every_field_of_our_actions_is_explained(client: TestClient, name: str) -> None:
    document = client.get(f"/interfaces/action_tutorials_interfaces/action/{name}").json()
    for part in ("goal", "result", "feedback"):
        assert document[part]["description"].endswith(".")
        assert all(field["description"].endswith(".") for field in document[part]["properties"].values())


@pytest.mark.parametrize(
    ("path", "status", "code", "detail"),
    [
        (
            "slam_msgs/action/MakeMap",
            404,
            "interface_not_found",
            "ROS interfaces slam_msgs (such as ros-",
        ),
        ("a.b/action/C", 422, "invalid_field", "package"),
        ("os/action/path", 422, "invalid_field", "name"),
        ("test_msgs/action/Fibonacci%0A", 422, "invalid_field", "name"),
        (f"{'a' * 200}/action/C", 422, "invalid_field", "package"),
        ("test_msgs/msg/Empty", 404, "not_found", ""),
        (f"{DOCK}?verbose=1", 422, "invalid_field", "verbose"),
    ],
)
def test_problems(client: TestClient, path: str, status: int, code: str, detail: str) -> None:
    answer = client.get(f"/interfaces/{path}")
    assert answer.headers["content-type"] == "application/problem+json"
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert detail in answer.json()["detail"]
