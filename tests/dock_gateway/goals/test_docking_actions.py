"""Which of a robot's docking actions is picked."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.dock_adapters import charging_dock, create3, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.goals.docking_actions import DockingActions
from dock_gateway.settings import Settings


class Graph:
    """The actions of the robot `/r`."""

    def __init__(self, **settings: str) -> None:
        self.actions: dict[str, Any] = {}
        self.docking = DockingActions(DockingCatalog(Settings(**settings)), self.actions)  # type: ignore[arg-type]
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

    def picked(self) -> tuple[str, str]:
        self.docking.update()
        dock, undock = self.docking.of("/r")
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
    del graph.actions["/r/disconnect_from_charging_dock"]
    assert graph.picked() == (OURS[0], NAV2[1]), "there is no other"


def test_one_that_vanishes_stays_until_there_is_another(graph: Graph) -> None:
    graph.add(nav2.DOCK)
    assert graph.picked() == (NAV2[0], OURS[1])
    graph.actions["/r/dock_robot"].on_graph = False
    assert graph.picked()[0] == NAV2[0]
    del graph.actions["/r/dock_robot"]
    assert graph.picked()[0] == NAV2[0]
    graph.add(create3.DOCK)
    assert graph.picked()[0] == "dock"
    del graph.actions["/r/dock"]
    graph.docking.forget("/r")
    assert graph.picked() == OURS


def test_an_action_with_such_a_name_that_is_no_docking_action(graph: Graph) -> None:
    graph.add(create3.DOCK)
    graph.actions["/r/dock"].verb = None
    assert graph.picked() == OURS
    assert "/r/dock" not in graph.docking.all_names("/r", "dock")
    assert graph.docking.all_names("/r", "dock") == {"/r/connect_to_charging_dock", "/r/dock_robot"}
