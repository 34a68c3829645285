"""Reads what is known of a mission's robot and of the goal of its present step."""

from collections.abc import Callable

from dock_gateway.core.battery import BatteryReading, PowerSupply
from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import Goal
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.moves import Facts
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.extensions.missions.step_entry import StepStatus
from dock_gateway.fleet.robot_state import CHARGES
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.stop.last_stops import LastStops
from dock_gateway.storage import History


class FactsReader:
    """Reads the facts for missions.

    Args:
        robots: The robots, with their batteries.
        actions: All actions.
        goals: Their goals.
        history: Finds goals that were sent before a restart.
        places: The places that steps drive to.
        interlock: The latched stops.
        last_stops: When robots were last stopped.
        docked: Returns whether a robot is docked; None if that is unknown.
    """

    def __init__(
        self,
        *,
        robots: RobotRegistry,
        actions: ActionRegistry,
        goals: Goals,
        history: History,
        places: Places,
        interlock: Interlock,
        last_stops: LastStops,
        docked: Callable[[str], bool | None],
    ) -> None:
        self._robots = robots
        self._actions = actions
        self._goals = goals
        self._history = history
        self._places = places
        self._interlock = interlock
        self._last_stops = last_stops
        self._docked = docked

    async def read(self, mission_id: str, mission: MissionEntry) -> Facts:
        """Return the facts, without those that only the gateway knows that sends or cancels the goal.

        Raises:
            Unavailable: The history does not answer.
        """
        step, robot = mission.current, mission.its_robot
        goal = await self._goal(mission_id, mission) if step.has_goal else None
        battery = self._battery(robot)
        return Facts(
            stopped=self._last_stops.any_since(robot, mission.allowed_since),
            latched=self._interlock.holds(robot),
            other_goal=has_other_goal(robot, step.goal_id, self._actions, self._robots),
            battery=battery.percentage,
            charging=battery.power_supply in CHARGES,
            full=battery.power_supply == PowerSupply.FULL,
            discharging=battery.power_supply == PowerSupply.DISCHARGING,
            docked=self._docked(robot) if mission.parked or step.verb == "dock" else None,
            place=await self._places.pose_of(step) if step.status is StepStatus.WAITING else None,
            goal=goal,
        )

    def _battery(self, robot: str) -> BatteryReading:
        """Return what the battery of a robot says; nothing if that is not recent."""
        latest = self._robots.get(robot).battery if robot in self._robots else None
        return BatteryReading() if latest is None or latest.age is None or latest.stale_since else latest.reading

    async def _goal(self, mission_id: str, mission: MissionEntry) -> Goal | None:
        """Return the goal of the present step, which may have been sent before a restart; None if there is none."""
        goal_id = mission.current.goal_id
        if goal_id is None:
            return await self._history.by_key(key_of_try(mission_id, mission))
        try:
            return await self._goals.get(goal_id)
        except NotFound:
            return None


def has_other_goal(robot: str, goal_id: str | None, actions: ActionRegistry, robots: RobotRegistry) -> bool:
    """Return whether a goal runs on a robot that is not this one."""
    owners = (robots.owner(each.action_name) for each in actions.running() if each.goal_id != goal_id)
    return any(owner is not None and owner.namespace == robot for owner in owners)


def key_of_try(mission_id: str, mission: MissionEntry) -> str:
    """Return the idempotency key of the goal of a mission's present step and try."""
    return f"mission-{mission_id}-{mission.position}-{mission.current.attempt}"
