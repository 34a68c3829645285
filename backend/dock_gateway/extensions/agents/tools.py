"""The tools of agents. Each is a declared operation, and what changes something is the very command that `/ws` has."""

import orjson

from dock_gateway.access.carry_out import Fields
from dock_gateway.access.tool import Nothing, Tool
from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role
from dock_gateway.extensions.agents import schema
from dock_gateway.extensions.agents.reading import (
    describe_action,
    explain_goal,
    list_actions,
    list_alerts,
    list_goals,
    list_robots,
    wait_for_goal,
)
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.streams import commands


@operation(Role.AGENT, Scope.APPROVAL)
async def answer_approval(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Take the answer of the person who uses an agent, in the agent's own program."""
    by = f"the user of {principal.name or principal.client}"
    approval = parts[Approvals].decide(fields["approval_id"], allow=fields["allow"], by=by)
    return {"approval_id": approval.id}


# ---------------------------------------------------------------------- what the tools' arguments mean to commands


async def _dock(_: Parts, __: Principal, fields: Fields) -> Fields:
    dock_id = fields.pop("dock_id", None)
    return {**fields, "goal": None if dock_id is None else {"dock_id": dock_id}}


async def _undock(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    with parts[DockingHints].hinting(fields.get("robot"), principal.grant):
        action = await parts[ActionRegistry].find_docking("undock", fields.pop("robot", None), principal.grant)
    message = action.port.encode_goal(action.read_docking_request())
    return {**fields, "action": action.name, "goal": orjson.loads(message)}


PERSON = (
    " If the robot is real, a person has to allow the goal first: the call then waits up to a minute, and fails if the "
    "person refuses or does not answer. Do not send a refused goal again unless a person asks for it."
)
GOES_ON = " Progress is reported while it runs. If the call ends early, the goal goes on: follow it with wait_for_goal."
STOP_TOOL = "stop_robots"
TOOLS = {
    tool.name: tool
    for tool in (
        Tool(
            "list_robots",
            "List robots",
            "List the robots with battery charge (0 to 1), whether they are docked, charging, simulated or stopped, "
            "and their running goals. Call this first. A value that is not known is null.",
            list_robots,
            Nothing,
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
            "Ask the action server to end a goal of any client early. The robot then stands still. In an emergency "
            "use stop_robots.",
            commands.cancel_goal,
            schema.OfGoal,
            schema.GoalAnswer,
            repeatable=True,
        ),
        Tool(
            STOP_TOOL,
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
            Nothing,
            schema.AlertList,
            reads=True,
        ),
    )
}
