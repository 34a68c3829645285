"""Robots that were stopped: their automatic docking waits until a person continues it (ISO 3691-4)."""

from typing import Any

from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.extensions.automation.decision import HoldEntry
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.storage.shared_entries import SharedEntries


class Holds:
    """The holds of all gateways that share the history, by robot.

    A released stop does not make a robot move: a person continues its automatic docking, or has sent it a goal since
    that succeeded.

    Args:
        robots: The robots.
        entries: Stores the holds.
    """

    def __init__(self, robots: RobotRegistry, entries: SharedEntries[HoldEntry]) -> None:
        self._robots = robots
        self._entries = entries

    def has(self, robot: str) -> bool:
        """Return whether no rule docks a robot."""
        return self._entries.get(robot) is not None

    def documents(self) -> list[dict[str, Any]]:
        """Return the holds as `GET /automation/holds` shows them, by robot."""
        return [{"robot": robot, "held_at": hold.held_at} for robot, hold in sorted(self._entries.all().items())]

    def hold(self, robot: str) -> None:
        """Hold a robot that is stopped, or whose stop is released."""
        self._entries.put(robot, HoldEntry(held_at=utc_now()))

    def on_end(self, goal: Goal) -> None:
        """Continue the automatic docking of a robot whose goal has succeeded, unless a rule or a mission sent it."""
        robot = self._robots.owner(goal.action_name)
        hold = None if robot is None else self._entries.get(robot.namespace)
        if robot is None or hold is None or goal.origin == "automation":
            return
        if goal.status is GoalStatus.SUCCEEDED and goal.created_at > hold.held_at:
            self._entries.put(robot.namespace, None)

    async def end(self, robot: str) -> None:
        """Continue the automatic docking of a robot, at every gateway that shares the history.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); the robot stays where it is.
        """
        await self._entries.read()
        if self.has(robot):
            await self._entries.store(robot, None, lambda _: None)

    async def sync(self) -> None:
        """Store the holds of this gateway, and read those of others."""
        await self._entries.sync()
