"""The tools of agents. Each is a declared operation, and what changes something is the very command that `/ws` has."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import orjson

from dock_gateway.access.authorization import subscribed
from dock_gateway.agents import schema
from dock_gateway.core.access import Principal
from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.grant import Role
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.fleet.overview import Fleet
from dock_gateway.goals.action_routes import describe
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.owners import Owners
from dock_gateway.goals.queries import read_goal_filter
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.graph.interface_routes import interface_document
from dock_gateway.http.bodies import read_model
from dock_gateway.http.operation import Audit, Operation, Scope, operation, operation_of
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import read_goal_id
from dock_gateway.http.schema import Schema
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.streams import commands
from dock_gateway.streams.commands import Command, Fields
from dock_gateway.streams.feed import feed
from dock_gateway.streams.queries import read_event_filter

# The states of a goal that are not its success, as a sentence begins.
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


# ---------------------------------------------------------------------- reading


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_robots(parts: Parts, principal: Principal, _: Fields) -> Fields:
    """List the robots: where they are, how charged, whether they are stopped."""
    return {"robots": [_robot(document) for document in parts[Fleet].documents(grant=principal.grant)]}


def _robot(document: Mapping[str, Any]) -> dict[str, Any]:
    robot = orjson.loads(encode(document))
    return {name: robot[name] for name in ("name", "display_name", "simulated", "docked", "charging")} | {
        "battery_percentage": robot["battery"].get("percentage"),
        "stopped": robot["stop"]["latched"],
        "stopped_by": robot["stop"].get("by"),
        "can_dock": robot["dock"] is not None,
        "can_undock": robot["undock"] is not None,
        "running_goals": [goal["goal_id"] for goal in robot["goals"]],
    }


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_actions(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """List the actions on the ROS graph."""
    robot, names = fields.get("robot"), ("action_name", "action_type", "verb", "available", "running_goals", "hint")
    covered = (each for each in parts[ActionRegistry].all() if principal.grant.covers_action(each.name))
    shown = [describe(action) for action in covered if robot is None or is_under(action.name, robot)]
    return {"actions": [{name: action[name] for name in names} for action in shown]}


@operation(Role.VIEWER, Scope.NEW_GOAL, Audit.NEVER)
async def describe_action(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Return the JSON Schema of an action's goal, result and feedback."""
    action = await parts[ActionRegistry].find(parts[Settings].resolve(fields["action"]))
    messages = orjson.loads(interface_document(action.type))
    return {"action_name": action.name, "action_type": messages.pop("type"), **messages}


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_goals(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """List goals of every sender, newest first."""
    action, status = fields.get("action"), fields.get("status")
    wanted = await read_goal_filter(
        settings=parts[Settings],
        owners=parts[Owners],
        grant=principal.grant,
        robot=fields.get("robot"),
        action=None if action is None else [action],
        status=None if status is None else [status],
    )
    page, _ = await parts[Goals].page(wanted, fields["limit"])
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


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_alerts(parts: Parts, principal: Principal, _: Fields) -> Fields:
    """List the active alerts."""
    names = ("id", "kind", "robot", "severity", "since", "title", "detail")
    documents = parts[AlertBoard].documents(principal.grant)
    return {"alerts": [{name: alert[name] for name in names} for alert in documents]}


@operation(Role.VIEWER, Scope.GOAL, Audit.NEVER)
async def wait_for_goal(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Return a goal, for whose end the caller waits."""
    return {"goal": goal_document(await parts[Goals].get(read_goal_id(fields["goal_id"])))}


@operation(Role.AGENT, Scope.APPROVAL)
async def answer_approval(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Take the answer of the person who uses an agent, in the agent's own program."""
    by = f"the user of {principal.name or principal.client}"
    approval = parts[Approvals].decide(fields["approval_id"], allow=fields["allow"], by=by)
    return {"approval_id": approval.approval_id}


# ---------------------------------------------------------------------- what the tools' arguments mean to commands


async def _dock(_: Parts, __: Principal, fields: Fields) -> Fields:
    dock_id = fields.pop("dock_id", None)
    return {**fields, "goal": None if dock_id is None else {"dock_id": dock_id}}


async def _undock(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    with parts[RobotActions].hinting(fields.get("robot"), principal.grant):
        action = await parts[RobotActions].find("undock", fields.pop("robot", None), principal.grant)
    message = action.port.encode_goal(action.parse_request(action.default_request))
    return {**fields, "action": action.name, "goal": orjson.loads(message)}


async def _unchanged(_: Parts, __: Principal, fields: Fields) -> Fields:
    return fields


@dataclass(frozen=True)
class Tool:
    """A tool.

    Attributes:
        name: What agents call it.
        title: Its name for people.
        description: What it does, for a model that has to choose.
        command: What carries it out.
        takes: Its arguments.
        returns: Its answer.
        reads: Whether it changes nothing.
        moves: Whether it may move a robot.
        repeatable: Whether a second call with the same arguments changes nothing more.
        prepare: Makes the fields of the command.
    """

    name: str
    title: str
    description: str
    command: Command
    takes: type[Schema]
    returns: type[Schema]
    reads: bool = False
    moves: bool = False
    repeatable: bool = False
    prepare: Any = _unchanged
    operation: Operation = field(init=False)

    def __post_init__(self) -> None:
        """Refuse a command that does not say what it needs."""
        object.__setattr__(self, "operation", operation_of(self.command))

    def read(self, arguments: object) -> Fields:
        """Return the arguments of a call, with defaults and without what was not given.

        Raises:
            InvalidField: They are not what the tool takes.
        """
        read = read_model(self.takes, {} if arguments is None else arguments)
        return {name: value for name, value in read.model_dump().items() if value is not None}


PERSON = (
    " If the robot is real, a person has to allow the goal first: the call then waits up to a minute, and fails if the "
    "person refuses or does not answer. Do not send a refused goal again unless a person asks for it."
)
GOES_ON = " Progress is reported while it runs. If the call ends early, the goal goes on: follow it with wait_for_goal."
# Characters of a line of progress.
MAX_PROGRESS = 500
TOOLS = {
    tool.name: tool
    for tool in (
        Tool(
            "list_robots",
            "List robots",
            "List the robots with battery charge (0 to 1), whether they are docked, charging, simulated or stopped, "
            "and their running goals. Call this first. A value that is not known is null.",
            list_robots,
            schema.Nothing,
            schema.RobotList,
            reads=True,
        ),
        Tool(
            "list_actions",
            "List actions",
            "List the ROS 2 actions that goals can be sent to. dock_robot and undock_robot know theirs.",
            list_actions,
            schema.OfRobot,
            schema.ActionList,
            reads=True,
        ),
        Tool(
            "describe_action",
            "Describe an action",
            "Return the JSON Schema of an action's goal, result and feedback. Call it before send_goal.",
            describe_action,
            schema.OfAction,
            schema.ActionMessages,
            reads=True,
        ),
        Tool(
            "dock_robot",
            "Dock a robot",
            "Drive a robot to its charging dock, and wait until it charges." + GOES_ON + PERSON,
            commands.send_goal,
            schema.DockArguments,
            schema.GoalAnswer,
            moves=True,
            prepare=_dock,
        ),
        Tool(
            "undock_robot",
            "Undock a robot",
            "Drive a robot off its charging dock, and wait until it has left it." + GOES_ON + PERSON,
            commands.send_goal,
            schema.UndockArguments,
            schema.GoalAnswer,
            moves=True,
            prepare=_undock,
        ),
        Tool(
            "send_goal",
            "Send a goal",
            "Send a goal to any ROS 2 action, and wait for its result." + GOES_ON + PERSON,
            commands.send_goal,
            schema.SendArguments,
            schema.GoalAnswer,
            moves=True,
        ),
        Tool(
            "wait_for_goal",
            "Wait for a goal",
            "Follow a goal that runs until it ends, or return one that has ended.",
            wait_for_goal,
            schema.WaitArguments,
            schema.GoalAnswer,
            reads=True,
        ),
        Tool(
            "cancel_goal",
            "Cancel a goal",
            "Ask the action server to end a goal early, whoever sent it. The robot then stands still. In an emergency "
            "use stop_robots.",
            commands.cancel_goal,
            schema.OfGoal,
            schema.GoalAnswer,
            repeatable=True,
        ),
        Tool(
            "stop_robots",
            "Stop robots",
            "Stop a robot, or every robot, at once: zero velocity, every goal canceled, no new goals. Use it whenever "
            "in doubt. Only a person can release the stop afterwards; there is no tool for that.",
            commands.stop,
            schema.StopArguments,
            schema.StopAnswer,
            repeatable=True,
        ),
        Tool(
            "list_goals",
            "List goals",
            "List earlier and running goals of every sender, newest first.",
            list_goals,
            schema.ListGoalsArguments,
            schema.GoalList,
            reads=True,
        ),
        Tool(
            "explain_goal",
            "Explain a goal",
            "Say why a goal failed or how it ended: the reason of the action server, the last stage, each change of "
            "its state.",
            explain_goal,
            schema.OfGoal,
            schema.Explanation,
            reads=True,
        ),
        Tool(
            "list_alerts",
            "List alerts",
            "List what an operator has to know now, such as a low battery, with advice.",
            list_alerts,
            schema.Nothing,
            schema.AlertList,
            reads=True,
        ),
    )
}


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
