"""The robots on the graph: whether each docks, and the settings that make it."""

from typing import Any

import pytest

from dock_gateway.core.snapshot import GraphSnapshot
from dock_gateway.doctor.check import Check, Level
from dock_gateway.doctor.robots import RobotChecks, merge_settings
from dock_gateway.settings import Settings

OURS = "action_tutorials_interfaces/action/ConnectToChargingDock"
CREATE3 = {"/tb4/dock": ["irobot_create_msgs/action/Dock"], "/tb4/undock": ["irobot_create_msgs/action/Undock"]}
NAV2 = {
    "/docking/dock_robot": ["nav2_msgs/action/DockRobot"],
    "/docking/undock_robot": ["nav2_msgs/action/UndockRobot"],
}

TO_100 = {"/tb4": {"battery": {"percentage": "0-100"}}}


def battery(percentage: float | None = 0.87, **more: Any) -> dict[str, Any]:
    stamp = {"stamp": {"sec": 0, "nanosec": 0}}
    return {"header": stamp, "percentage": percentage, "power_supply_status": 2, "voltage": 14.0, **more}


def checks(settings: Settings | None = None, **seen: Any) -> dict[str, Check]:
    snapshot = GraphSnapshot(4.0, **{"nodes": 3, **seen})
    return {check.name: check for check in RobotChecks(settings or Settings(), snapshot, {}).all()}


def test_a_robot_that_docks() -> None:
    check = checks(
        actions={"/robot1/connect_to_charging_dock": [OURS]}, batteries={"/robot1/battery_status": battery()}
    )["robot /robot1"]
    assert check.level is Level.OK
    assert f"docks with /robot1/connect_to_charging_dock ({OURS})" in check.text
    assert "battery on /robot1/battery_status at 87 %, DISCHARGING" in check.text


def test_a_turtlebot_4_and_the_settings_that_make_the_button_work() -> None:
    seen: dict[str, Any] = {"actions": CREATE3, "batteries": {"/tb4/battery_state": battery(87.0)}}
    found = checks(**seen)
    assert found["graph"].level is Level.OK
    assert found["robot /tb4"].level is Level.WARNING
    lines = ['battery_topic = "battery_state"', 'robots."/tb4".battery.percentage = "0-100"']
    assert found["robot /tb4"].settings == lines
    assert "docks with /tb4/dock (irobot_create_msgs/action/Dock); undocks with /tb4/undock" in found["robot /tb4"].text
    check = checks(
        Settings.model_validate({"battery_topic": "battery_state", "robots": TO_100}),
        **seen,
    )["robot /tb4"]
    assert check.level is Level.OK
    assert "at 87 %" in check.text


def test_a_battery_topic_of_one_of_several_robots() -> None:
    batteries = {"/robot1/battery_status": battery(), "/tb4/battery_state": battery()}
    check = checks(actions=CREATE3, batteries=batteries)["robot /tb4"]
    assert check.settings == ['robots."/tb4".battery.topic = "/tb4/battery_state"']


def test_a_docking_server_in_another_namespace() -> None:
    found = checks(actions=NAV2, batteries={"/robot1/battery_status": battery()})
    assert found["robot /robot1"].settings == [
        'robots."/robot1".dock_action = "/docking/dock_robot"',
        'robots."/robot1".undock_action = "/docking/undock_robot"',
    ]
    assert "No battery" in found["robot /docking"].text
    joined = Settings.model_validate(
        {"robots": {"/robot1": {"dock_action": "/docking/dock_robot", "undock_action": "/docking/undock_robot"}}}
    )
    found = checks(joined, actions=NAV2, batteries={"/robot1/battery_status": battery()})
    assert {name: check.level for name, check in found.items()} == {"graph": Level.OK, "robot /robot1": Level.OK}


def test_two_servers_and_a_package_that_is_not_installed() -> None:
    dock = "/robot1/dock_robot"
    check = checks(actions={dock: ["nav2_msgs/action/DockRobot"]}, servers={dock: 2})["robot /robot1"]
    assert check.level is Level.ERROR
    assert f"{dock} has 2 servers" in check.text
    check = checks(Settings(dock_action="dance"), actions={"/robot1/dance": ["no_msgs/action/Dance"]})["robot /robot1"]
    assert check.level is Level.ERROR
    assert "no_msgs is not installed" in check.text


@pytest.mark.parametrize(
    ("state", "said"),
    [
        (None, "has sent nothing in 4 s"),
        (battery(-1.0), "percentage is -1"),
        (battery(voltage="inf"), "voltage is inf"),
        (battery(header={"stamp": {"sec": 5, "nanosec": 0}}), "header.stamp is 5"),
    ],
)
def test_batteries_that_are_not_believed(state: dict[str, Any] | None, said: str) -> None:
    check = checks(actions={"/robot1/connect_to_charging_dock": [OURS]}, batteries={"/robot1/battery_status": state})[
        "robot /robot1"
    ]
    assert check.level is Level.WARNING
    assert said in check.text


def test_an_empty_graph() -> None:
    (check,) = checks(nodes=0).values()
    assert check.level is Level.WARNING
    assert "see that its ROS_DOMAIN_ID is 0 as here" in check.text
    assert "docs/nav2.md" in checks(nodes=7)["graph"].text


def test_each_line_comes_once() -> None:
    merged = merge_settings([Check("", Level.OK, "", lines) for lines in (["A=1", "B=2"], ["A=3", "B=2"])])
    assert merged == ["A=1", "B=2", "A=3"]
