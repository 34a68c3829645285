"""Which of a robot's docking actions is picked, and which robot an action belongs to."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.dock_adapters import charging_dock, create3, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.settings import Settings
from tests.support.robot_actions import make_robot_actions


class Graph:
    """The actions of the robot `/r`."""

    def __init__(self, **settings: str) -> None:
        self.actions: dict[str, Any] = {}
        self.docking = make_robot_actions(Settings(**settings))  # type: ignore[arg-type]
        self.changes: list[str] = []
        self.docking.on_change.append(self.changes.append)

    def add(self, *adapters: DockAdapter, name: str = "") -> None:
        for adapter in adapters:
            full = f"/r/{name or adapter.action_name}"
            self.actions[full] = SimpleNamespace(
                name=full,
                type=adapter.action_type,
                verb=adapter.verb,
                family=adapter.family,
                on_graph=True,
                busy=False,
            )
            self.docking.add(self.actions[full])

    def remove(self, name: str) -> None:
        del self.actions[name]
        self.docking.remove(name)

    def picked(self) -> tuple[str, str]:
        self.docking.update()
        dock, undock = self.docking.docking_pair("/r")
        return dock.removeprefix("/r/"), undock.removeprefix("/r/")


OURS = ("connect_to_charging_dock", "disconnect_from_charging_dock")
NAV2 = ("dock_robot", "undock_robot")


@pytest.fixture
def graph() -> Graph:
    return Graph()


def test_ours_where_there_is_none(graph: Graph) -> None:
    assert graph.picked() == OURS
    assert graph.changes == []


def test_the_order_of_preference(graph: Graph) -> None:
    graph.add(create3.DOCK, create3.UNDOCK)
    assert graph.picked() == ("dock", "undock")
    graph.add(nav2.DOCK, nav2.UNDOCK)
    assert graph.picked() == NAV2
    graph.add(charging_dock.DOCK, charging_dock.UNDOCK)
    assert graph.picked() == OURS
    assert graph.changes == ["/r", "/r", "/r"]


def test_a_configured_one_comes_first() -> None:
    graph = Graph(dock_action="dock", undock_action="park_out")
    graph.add(charging_dock.DOCK, charging_dock.UNDOCK, create3.DOCK)
    assert graph.picked() == ("dock", OURS[1])
    graph.add(DockAdapter("undock"), name="park_out")
    assert graph.picked() == ("dock", "park_out")


def test_one_with_a_running_goal_stays(graph: Graph) -> None:
    graph.add(nav2.DOCK, nav2.UNDOCK)
    graph.actions["/r/dock_robot"].busy = True
    graph.add(charging_dock.DOCK, charging_dock.UNDOCK)
    assert graph.picked() == NAV2
    graph.actions["/r/dock_robot"].busy = False
    assert graph.picked() == OURS


def test_who_docks_undocks(graph: Graph) -> None:
    graph.add(nav2.DOCK, nav2.UNDOCK, charging_dock.UNDOCK)
    assert graph.picked() == NAV2
    graph.add(charging_dock.DOCK)
    graph.remove("/r/disconnect_from_charging_dock")
    assert graph.picked() == (OURS[0], NAV2[1]), "there is no other"


def test_one_that_vanishes_stays_until_there_is_another(graph: Graph) -> None:
    graph.add(nav2.DOCK)
    assert graph.picked() == (NAV2[0], OURS[1])
    graph.actions["/r/dock_robot"].on_graph = False
    assert graph.picked()[0] == NAV2[0]
    graph.remove("/r/dock_robot")
    assert graph.picked()[0] == NAV2[0]
    graph.add(create3.DOCK)
    assert graph.picked()[0] == "dock"
    graph.remove("/r/dock")
    graph.docking.forget("/r")
    assert graph.picked() == OURS


def test_an_action_with_such_a_name_that_is_no_docking_action(graph: Graph) -> None:
    graph.add(create3.DOCK)
    graph.actions["/r/dock"].verb = None
    assert graph.picked() == OURS
    assert "/r/dock" not in graph.docking.docking_names("/r", "dock")
    assert graph.docking.docking_names("/r", "dock") == {"/r/connect_to_charging_dock", "/r/dock_robot"}


def test_an_action_belongs_to_the_innermost_robot_that_is_known_or_was() -> None:
    actions = make_robot_actions(
        Settings.model_validate({"robots": {"/on_graph": {"dock_action": "/servers/dock_it"}}}), "/", "/on_graph"
    )
    names = {
        "/on_graph/arm/wave": "/on_graph",
        "/servers/dock_it": "/on_graph",
        "/gone/dock_robot": "/gone",
        "/gone/arm/wave": "/gone",
        "/elsewhere/wave": "/",
    }
    assert actions.robots_of(names) == names
    assert actions.robots_of(["/gone/arm/wave"]) == {"/gone/arm/wave": "/"}, "nothing says that it was a robot"


def test_an_action_in_no_robots_namespace_is_of_its_own_namespace() -> None:
    assert make_robot_actions().robots_of(["/arm/wave"]) == {"/arm/wave": "/arm"}


def test_the_actions_below_a_namespace_are_those_of_its_robots_and_shared_ones() -> None:
    actions = make_robot_actions(
        Settings.model_validate(
            {"undock_action": "/fleet/undock", "robots": {"/r": {"dock_action": "/servers/dock_it"}}}
        )
    )
    names = ("/r/wave", "/r/arm/wave", "/servers/dock_it", "/fleet/undock", "/r2/wave", "/servers/other")
    assert [name for name in names if actions.is_below(name, "/r")] == list(names[:4])
