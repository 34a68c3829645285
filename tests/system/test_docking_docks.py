"""Docks by name and by type, over DDS."""

import math
from pathlib import Path

import pytest
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters
from std_srvs.srv import Trigger

from docking.core.geometry import Pose, normalize_angle
from docking.goal.plan import Plan
from docking.parameters import DockSettings
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from tests.support.docking import (
    LOW,
    SERVER,
    SUCCEEDED,
    Reports,
    dock_server,
    docking_servers,
    send_dock_goal,
    send_undock_goal,
)
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import look_at

pytestmark = pytest.mark.ros

BACKED = DOCKED.compose(Pose(theta=math.pi))

DOCKS = """
docks:
  home: {type: near, frame: map, pose: [1, 2.5, 0], id: 7}
  lab: {type: far}
"""


def test_goals_go_to_a_dock_by_name(domain: int, observer: Observer, tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text(DOCKS)
    offsets: list[float] = []

    def remember(settings: DockSettings) -> Plan:
        offsets.append(settings.dock.staging_x_offset)
        return make_plan(settings)

    database = (f"dock_database:={path}", "dock_plugins:=[near, far]", "far.staging_x_offset:=-1.0")
    with dock_server(domain, *database, make_plan=remember), observer.publishing(LOW, "battery_status"):
        reports = Reports(observer)
        unknown = send_dock_goal(observer, dock="nope")
        assert not unknown.accepted
        report = reports.wait_for(goal_id=unknown.goal_id, error_code="DOCK_NOT_IN_DB", error_number="901")
        assert report["error_msg"] == "there is no dock 'nope', but: home, lab"

        for dock in ("", "home", "lab"):
            goal = send_dock_goal(observer, dock=dock)
            assert goal.accepted
            assert goal.cancel()
            goal.result()
        assert offsets == [-0.7, -0.7, -1.0]

        listed = observer.request(
            ListParameters, f"{SERVER}/list_parameters", ListParameters.Request(prefixes=["home"])
        )
        assert listed.result.names == ["home.type", "home.frame", "home.pose", "home.id"]
        names = ["docks", "home.pose", "home.id", "far.staging_x_offset", "lab.pose"]
        values = observer.request(GetParameters, f"{SERVER}/get_parameters", GetParameters.Request(names=names)).values
        assert values[0].string_array_value == ["home", "lab"]
        assert list(values[1].double_array_value) == [1.0, 2.5, 0.0]
        assert (values[2].string_value, values[3].double_value) == ("7", -1.0)
        assert list(values[4].double_array_value) == []
        (docks,) = observer.request(
            DescribeParameters, f"{SERVER}/describe_parameters", DescribeParameters.Request(names=["docks"])
        ).descriptors
        assert docks.read_only
        assert "first one" in docks.description

        def reload() -> tuple[bool, str]:
            answer = observer.request(Trigger, "reload_docks", Trigger.Request())
            return answer.success, answer.message

        path.write_text("docks: {attic: {type: far}, home: {type: far, pose: [9, 9, 0]}}")
        assert reload() == (True, "2 docks: attic, home")
        assert not send_dock_goal(observer, dock="lab").accepted
        goal = send_dock_goal(observer)
        assert goal.accepted
        path.write_text("docks: {cellar: {type: low}}")
        assert reload() == (
            False,
            "the docks are as before: cellar.type is 'low', but must be one of dock_plugins (there: near, far)",
        )
        path.write_text("docks: 7")
        assert not reload()[0]
        values = observer.request(
            GetParameters, f"{SERVER}/get_parameters", GetParameters.Request(names=names[:3])
        ).values
        assert values[0].string_array_value == ["attic", "home"]
        assert list(values[1].double_array_value) == [9.0, 9.0, 0.0]
        assert values[2].string_value == ""
        assert "read-only" in observer.set_parameter(SERVER, "docks", ["home"])
        assert goal.cancel()
        goal.result()
        assert offsets == [-0.7, -0.7, -1.0, -1.0]


def test_a_robot_backs_onto_a_dock_of_that_type_and_leaves_it_forwards(domain: int, observer: Observer) -> None:
    types = ("docks:=[home, garage]", "dock_plugins:=[front, back]", "home.type:=front", "garage.type:=back")
    back = ("back.dock_direction:=backward", "back.rotate_to_dock:=true")
    with (
        dock_simulator(domain, "start_x:=-1.1", "start_y:=0.0", "start_theta:=0.0", "contact_at_back:=true"),
        docking_servers(domain, "controller:=dock_pose", *types, *back),
    ):
        site = look_at(observer)
        assert send_dock_goal(observer, dock="garage").result(120.0).status == SUCCEEDED
        site.expect_standstill()
        assert site.controls.status["docked"] == "true"
        assert site.pose.distance_to(BACKED) < 0.03
        assert abs(normalize_angle(site.pose.theta - BACKED.theta)) < math.radians(6.0)

        driven = len(site.wheels.messages)
        assert send_undock_goal(observer).result().status == SUCCEEDED
        assert min(message.linear.x for message in site.wheels.messages[driven:]) >= 0.0
        assert site.pose.x < -0.8
