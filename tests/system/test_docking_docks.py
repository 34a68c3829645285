"""Docks by name, over DDS."""

from pathlib import Path

import pytest
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters

from docking.goal.plan import Plan
from docking.parameters import DockSettings
from docking.plans.registry import make_plan
from tests.support.docking import LOW, Reports, dock_server, send_dock_goal
from tests.support.observer import Observer
from tests.system.test_docking_calibration import SERVER, ask

pytestmark = pytest.mark.ros

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

        listed = observer.result_of(
            ask(observer, ListParameters, f"{SERVER}/list_parameters", ListParameters.Request(prefixes=["home"])),
            "the list",
        )
        assert listed.result.names == ["home.type", "home.frame", "home.pose", "home.id"]
        names = ["docks", "home.pose", "home.id", "far.staging_x_offset", "lab.pose"]
        values = observer.result_of(
            ask(observer, GetParameters, f"{SERVER}/get_parameters", GetParameters.Request(names=names)), "the values"
        ).values
        assert values[0].string_array_value == ["home", "lab"]
        assert list(values[1].double_array_value) == [1.0, 2.5, 0.0]
        assert (values[2].string_value, values[3].double_value) == ("7", -1.0)
        assert list(values[4].double_array_value) == []
        (docks,) = observer.result_of(
            ask(
                observer,
                DescribeParameters,
                f"{SERVER}/describe_parameters",
                DescribeParameters.Request(names=["docks"]),
            ),
            "the description",
        ).descriptors
        assert docks.read_only
        assert "first one" in docks.description
