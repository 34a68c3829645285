"""The actions that missions send goals to, and the goals that are sent."""

from typing import Any

from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.step import StepFields
from dock_gateway.goals.action import Action
from dock_gateway.goals.robot_actions import RobotActions


def action_of(step: StepFields, robot: str, robot_actions: RobotActions) -> str | None:
    """Return the name of the action of a step; None if it sends no goal."""
    if step.action is not None:
        return step.action.name
    return None if step.verb is None else robot_actions.docking_name(step.verb, robot)


def actions_of(mission: MissionEntry, robot_actions: RobotActions) -> set[str]:
    """Return the names of the actions that a mission sends goals to."""
    names = (action_of(step, mission.robot, robot_actions) for step in mission.steps)
    return set(filter(None, names))


def covers(mission: MissionEntry, grant: Grant, robot_actions: RobotActions) -> bool:
    """Return whether a grant covers the robot of a mission, and all actions that it sends goals to."""
    return grant.covers_robot(mission.robot) and all(map(grant.covers_action, actions_of(mission, robot_actions)))


async def read_goal(step: StepFields, action: Action, place: str = "") -> Any:
    """Return the goal message of a step.

    Args:
        step: The step.
        action: Its action.
        place: Where the step is in a request, for errors; empty: in none.

    Raises:
        InvalidField: It is not a goal of the action.
        Conflict: `stopped`: a stop was requested in the meantime.
    """
    path = place and f"{place}.{step.verb or 'action.goal'}"
    if step.verb is None:
        return await action.read_goal(step.request, path)
    return action.read_docking_request(step.request, path)
