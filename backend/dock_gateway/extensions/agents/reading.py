"""The operations by which agents read robots, actions, goals and alerts, and the progress of a goal."""

from collections.abc import Mapping
from typing import Any

import orjson

from dock_gateway.access.authorization import subscribed
from dock_gateway.access.carry_out import Fields
from dock_gateway.core.access import Principal
from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.grant import Role
from dock_gateway.goals import history_routes
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.queries import GoalQuery
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.interface_routes import interface_document
from dock_gateway.http.operation import Audit, Scope, carries_out, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import read_goal_id
from dock_gateway.operations import fleet
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.streams.feed import feed
from dock_gateway.streams.queries import read_event_filter

# Characters of a line of progress.
MAX_PROGRESS = 500
# How a goal ended, as a sentence.
_ENDS = {
    GoalStatus.SUCCEEDED: "The goal succeeded.",
    GoalStatus.CANCELED: "The goal was canceled.",
    GoalStatus.ABORTED: "The action server gave up.",
    GoalStatus.REJECTED: "The goal was not started.",
    GoalStatus.LOST: "The gateway lost contact with the action server; the robot may still be moving.",
}


def goal_document(goal: Goal) -> dict[str, Any]:
    """Return a goal as tools show it."""
    names = ("goal_id", "action_name", "status", "stage", "retries", "created_at", "finished_at", "error")
    document = goal.document()
    shown = {name: document[name] for name in (*names, "goal", "feedback", "result")}
    return shown | {"ended": goal.status.terminal}


def _percent(percentage: float | None) -> float | None:
    """Return in percent what ROS counts from 0 to 1: a model would take 0.24 for a quarter of a percent."""
    return None if percentage is None else round(100 * percentage, 1)


@carries_out(fleet.list_robots)
async def list_robots(parts: Parts, principal: Principal, _: Fields) -> Fields:
    """List the robots: where they are, how charged, whether they are stopped."""
    return {"robots": [_robot(document) for document in await fleet.list_robots(parts, principal)]}


def _robot(document: Mapping[str, Any]) -> dict[str, Any]:
    robot = orjson.loads(encode(document))
    return {name: robot[name] for name in ("name", "display_name", "simulated", "docked", "charging")} | {
        "battery_percent": _percent(robot["battery"].get("percentage")),
        "stopped": robot["stop"]["latched"],
        "stopped_by": robot["stop"].get("by"),
        "can_dock": robot["dock"] is not None,
        "can_undock": robot["undock"] is not None,
        "running_goals": [goal["goal_id"] for goal in robot["goals"]],
    }


@carries_out(fleet.list_actions)
async def list_actions(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """List the actions on the ROS graph that goals can be sent to."""
    robot, names = fields.get("robot"), ("action_name", "action_type", "verb", "available", "running_goals", "hint")
    found = [each for each in await fleet.list_actions(parts, principal, hidden=True) if each["installed"]]
    shown = [action for action in found if robot is None or is_under(action["action_name"], robot)]
    return {"actions": [{name: action[name] for name in names} for action in shown]}


@operation(Role.VIEWER, Scope.NEW_GOAL, Audit.NEVER)
async def describe_action(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Return the JSON Schema of an action's goal, result and feedback."""
    action = await parts[ActionRegistry].find(parts[Settings].resolve(fields["action"]))
    messages = orjson.loads(interface_document(action.type))
    return {"action_name": action.name, "action_type": messages.pop("type"), **messages}


@carries_out(history_routes.list_goals)
async def list_goals(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """List goals of every sender, newest first."""
    action, status = fields.get("action"), fields.get("status")
    query = GoalQuery.model_construct(  # the arguments of a tool were validated
        robot=fields.get("robot"),
        action=None if action is None else [action],
        status=None if status is None else [status],
    )
    page, _ = await parts[Goals].page(await query.to_filter(parts, principal.grant), fields["limit"])
    return {"goals": [goal_document(goal) for goal in page]}


@operation(Role.VIEWER, Scope.GOAL, Audit.NEVER)
async def explain_goal(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Say why a goal ended as it did."""
    goal = await parts[Goals].get(read_goal_id(fields["goal_id"]))
    events = await parts[History].events_of(goal.goal_id, kinds=frozenset({"status", "result"}), after="", limit=50)
    said = [_ENDS.get(goal.status, f"The goal has not ended: it is {goal.status}.")]
    if goal.error is not None:
        said.append(f"{goal.error.detail.rstrip('.')} ({goal.error.code}).")
    if goal.stage is not None and goal.status is not GoalStatus.SUCCEEDED:
        said.append(f"The last stage was {goal.stage!r}.")
    if goal.retries:
        said.append(f"Number of retries: {goal.retries}.")
    changes = [orjson.loads(event.data) for event in events]
    return {"explanation": " ".join(said), "goal": goal_document(goal), "events": changes}


@carries_out(fleet.list_alerts)
async def list_alerts(parts: Parts, principal: Principal, _: Fields) -> Fields:
    """List the active alerts."""
    names = ("id", "kind", "robot", "severity", "started_at", "title", "detail")
    return {"alerts": [{name: alert[name] for name in names} for alert in await fleet.list_alerts(parts, principal)]}


@operation(Role.VIEWER, Scope.GOAL, Audit.NEVER)
async def wait_for_goal(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Return a goal, for whose end the caller waits."""
    return {"goal": goal_document(await parts[Goals].get(read_goal_id(fields["goal_id"])))}


async def follow(parts: Parts, principal: Principal, goal_id: str, report: Any) -> None:
    """Report the progress of a goal until it ends, the reader may no longer read it, or the gateway closes.

    Args:
        parts: The parts of the gateway.
        principal: The agent.
        goal_id: The goal.
        report: Called with the number of reports and a line of text.
    """
    reports = 0
    wanted = await read_event_filter(parts, {"goal_id": goal_id}, principal.grant)
    with subscribed(parts, principal, wanted) as subscriber:
        async for event in feed(parts, subscriber, max_rate=1.0):
            document = orjson.loads(event.data)
            if document["type"] in ("status", "feedback"):
                reports += 1
                await report(reports, _progress(document))
            if event.ends_goal or document["type"] == "result":
                return


def _progress(document: Mapping[str, Any]) -> str:
    if document["type"] == "feedback":
        feedback = document["feedback"]
        if battery := feedback.get("current_battery_state"):  # of docking; the whole of it tells less
            return f"battery at {battery['voltage']} V, {battery['current']} A"
        return str(orjson.dumps(feedback).decode())[:MAX_PROGRESS]
    stage = document["stage"]
    return str(document["status"] if stage is None else f"{document['status']}: {stage}")
