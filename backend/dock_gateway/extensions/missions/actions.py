"""What missions use: the actions that they send goals to, services and topics."""

from typing import Any

from dock_gateway.core.filters import prefix_of
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions.mission import MissionEntry, StepEntry
from dock_gateway.extensions.missions.step import SingleStep
from dock_gateway.goals.action import Action
from dock_gateway.goals.robot_actions import RobotActions


def action_of(step: SingleStep, robot: str, robot_actions: RobotActions) -> str | None:
    """Return the name of the action of a step; None if it sends no goal."""
    if step.action is not None:
        return step.action.name
    if step.navigate is not None:
        return prefix_of(robot) + step.navigate.action
    return None if step.verb is None else robot_actions.docking_name(step.verb, robot)


def actions_of(mission: MissionEntry, robot_actions: RobotActions) -> set[str]:
    """Return the names of the actions that a mission sends goals to."""
    names = (action_of(step, mission.robot, robot_actions) for step in mission.steps)
    return set(filter(None, names))


def covers_message(step: SingleStep, grant: Grant) -> bool:
    """Return whether a grant covers the service or the topic of a step, if it has one."""
    if step.call is not None:
        return grant.covers_service(step.call.service)
    return step.publish is None or grant.covers_publishing(step.publish.topic)


def covers(mission: MissionEntry, grant: Grant, robot_actions: RobotActions) -> bool:
    """Return whether a grant covers the robot of a mission, and all that it uses."""
    return (
        grant.covers_robot(mission.robot)
        and all(map(grant.covers_action, actions_of(mission, robot_actions)))
        and all(covers_message(step, grant) for step in mission.steps)
    )


async def read_goal(step: StepEntry, action: Action, place: str = "") -> Any:
    """Return the goal message of a step.

    Args:
        step: The step.
        action: Its action.
        place: Where the step is in a request, for errors; empty: in none.

    Raises:
        InvalidField: It is not a goal of the action.
        Conflict: `stopped`: a stop was requested in the meantime.
    """
    kind = step.verb or ("navigate" if step.navigate is not None else "action.goal")
    path = place and f"{place}.{kind}"
    if step.verb is None:
        return await action.read_goal(step.request, path)
    return action.read_docking_request(step.request, path)
