"""States of robots, as alerts are judged by."""

from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

from dock_gateway.core.battery import BatteryReading, Doubt
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.goals.liveness import ServerState
from dock_gateway.robots.labels import NO_LABEL

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
UNKNOWN, CHARGING, DISCHARGING, NOT_CHARGING, FULL = 0, 1, 2, 3, 4
WRONG = Doubt("percentage", 12.0, "0 to 1", "Name the robot.")


def goal(action: str, status: GoalStatus = GoalStatus.EXECUTING, at: datetime = NOON) -> Goal:
    """A goal in a state, since a time."""
    goal = Goal("a", action, "pkg/action/Dock", at)
    goal.advance(status, at)
    return goal


def robot(
    name: str = "/robot1",
    *,
    supply: int = DISCHARGING,
    percentage: float | None = 0.5,
    current: float | None = None,
    doubts: tuple[Doubt, ...] = (),
    named: tuple[Doubt, ...] = (),
    stale_since: datetime | None = None,
    latched: bool = False,
    persisted: bool = True,
    contact: bool | None = None,
    **more: Any,
) -> RobotState:
    """A robot that is well but for what is said of it."""
    battery = SimpleNamespace(
        reading=BatteryReading(supply, percentage, current, doubts, named), stale_since=stale_since
    )
    known: dict[str, Any] = {
        "label": NO_LABEL,
        "default": False,
        "battery": battery,
        "battery_topic": f"{name}/battery_status",
        "publisher": None,
        "stop": {
            "latched": latched,
            "stopped_at": NOON if latched else None,
            "by": "Ada" if latched else None,
            "persisted": persisted,
        },
        "simulator": None if contact is None else {"contact": contact, "docked": None},
        "dock": ServerState(f"{name}/dock", "pkg/action/Dock", available=True, answering=True),
        "undock": ServerState(f"{name}/undock", "pkg/action/Dock", available=True, answering=True),
        "goals": [],
        "lost": [],
        "last_goal": None,
        "left_docked": None,
    }
    return RobotState(name, **(known | more))
