"""Which dock a goal message is for, by name, whatever its type; and the same message for another one."""

from typing import Any

import pytest

from dock_gateway.core.dock_adapters import charging_dock, create3, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter


def ours(location: str) -> dict[str, Any]:
    return {"desired_battery_state": {"location": location, "power_supply_status": 1}}


def nav2s(dock_id: str, *, by_id: bool = True) -> dict[str, Any]:
    return {"use_dock_id": by_id, "dock_id": dock_id, "dock_type": ""}


@pytest.mark.parametrize(
    ("adapter", "goal", "dock"),
    [
        (charging_dock.DOCK, ours("lab"), "lab"),
        (charging_dock.DOCK, ours(""), ""),
        (charging_dock.DOCK, ours("nearest"), ""),
        (charging_dock.DOCK, ours(' {"pose": [1, 2, 0]}'), None),
        (nav2.DOCK, nav2s("lab"), "lab"),
        (nav2.DOCK, nav2s(""), ""),
        (nav2.DOCK, nav2s("lab", by_id=False), None),
        (create3.DOCK, {}, None),
        (charging_dock.UNDOCK, ours("lab"), None),
        (nav2.UNDOCK, {"dock_type": ""}, None),
        (DockAdapter("dock"), {"dock_id": "lab"}, None),
    ],
)
def test_the_name_in_a_message(adapter: DockAdapter, goal: dict[str, Any], dock: str | None) -> None:
    assert adapter.dock_of(goal) == dock


@pytest.mark.parametrize(
    ("adapter", "goal", "named"),
    [(charging_dock.DOCK, ours("nearest"), ours("lab")), (nav2.DOCK, nav2s(""), nav2s("lab"))],
)
def test_a_message_with_a_name(adapter: DockAdapter, goal: dict[str, Any], named: dict[str, Any]) -> None:
    assert adapter.at_dock(goal, "lab") == named
    assert create3.DOCK.at_dock({}, "lab") == {}
