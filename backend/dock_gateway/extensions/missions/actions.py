"""What missions use: the actions that they send goals to, services and topics."""

from collections.abc import Callable, Collection, Iterable
from typing import Any

from dock_gateway.core.dock_adapters.catalog import ADAPTERS
from dock_gateway.core.filters import prefix_of
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.step import SingleStep
from dock_gateway.extensions.missions.step_entry import StepEntry
from dock_gateway.goals.action import Action
from dock_gateway.goals.robot_actions import RobotActions


def action_of(step: SingleStep, robot: str, robot_actions: RobotActions) -> str | None:
    """Return the name of the action of a step; None if it sends no goal."""
    if step.action is not None:
        return step.action.name
    if step.navigate is not None:
        return prefix_of(robot) + step.navigate.action
    return None if step.verb is None else robot_actions.docking_name(step.verb, robot)


def robots_of(mission: MissionEntry, members: Callable[[str], Collection[str]]) -> list[str]:
    """Return the robot of a mission; those that are in its group now, if none of them has begun it.

    Args:
        mission: The mission.
        members: Returns the robots of a group.
    """
    return sorted(members(mission.group or "")) if mission.robot is None else [mission.robot]


def actions_of(mission: MissionEntry, robots: Iterable[str], robot_actions: RobotActions) -> set[str]:
    """Return the names of the actions that a mission sends goals to, on any of these robots."""
    robots = [*robots]
    names = {action_of(step, robot, robot_actions) for robot in robots for step in mission.steps}
    if mission.battery is not None:
        names |= {robot_actions.docking_name(verb, robot) for verb in ADAPTERS for robot in robots}
    return set(filter(None, names))


def covers_message(step: SingleStep, grant: Grant) -> bool:
    """Return whether a grant covers the service or the topic of a step, if it has one."""
    if step.call is not None:
        return grant.covers_service(step.call.service)
    return step.publish is None or grant.covers_publishing(step.publish.topic)


def covers(
    mission: MissionEntry, grant: Grant, robot_actions: RobotActions, members: Callable[[str], Collection[str]]
) -> bool:
    """Return whether a grant covers the robot of a mission, or all of its group, and all that it uses.

    Args:
        mission: The mission.
        grant: The grant. The robots of a group may be served by several gateways: whose they are does not count.
        robot_actions: Which actions dock and undock each robot.
        members: Returns the robots of a group. A group without robots is covered by a grant that covers all.
    """
    robots = robots_of(mission, members)
    if mission.robot is None:
        grant = grant.own
    return (
        (bool(robots) or not grant.limited)
        and all(map(grant.covers_robot, robots))
        and all(map(grant.covers_action, actions_of(mission, robots, robot_actions)))
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
