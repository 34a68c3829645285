"""Goals of any action: they are sent and canceled."""

from dataclasses import dataclass

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal, Verb
from dock_gateway.core.grant import Role
from dock_gateway.core.request import acts_on
from dock_gateway.goals.action import Action
from dock_gateway.goals.cancellation import require_unfinished
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Parts


@dataclass(frozen=True)
class SendGoal:
    """A goal to send.

    Attributes:
        request: Decoded JSON, or the goal message: the fields of the message or, to dock or undock a robot, a simple
            request. None: the client gave none.
        action: Absolute name of the action; None: the one that docks or undocks the robot.
        verb: Which of them.
        robot: The robot; None: the configured one.
        key: The idempotency key as it is stored for who sends the goal; None: each goal is another one.
        path: Where the request was, for errors; empty: it is the whole body.
    """

    request: object
    action: str | None = None
    verb: Verb = "dock"
    robot: str | None = None
    key: str | None = None
    path: str = ""


@operation(Role.AGENT, Scope.NEW_GOAL, errors=(409, 504), sends_goal=True)
async def send_goal(parts: Parts, principal: Principal, order: SendGoal) -> tuple[Action, Goal]:
    """Send a goal to an action. Return the action and the goal, which has been accepted.

    Raises:
        GatewayError: There is no such action, the goal is not one of it, may not be sent, or was not accepted.
    """
    if order.action is not None:
        action = await parts[ActionRegistry].find(order.action)
        return action, await _submit(action, principal, order)
    with parts[DockingHints].hinting(order.robot, principal.grant):
        return await _send_docking_goal(parts, principal, order)


async def _send_docking_goal(parts: Parts, principal: Principal, order: SendGoal) -> tuple[Action, Goal]:
    """Send a goal to a robot's action or, if that has no server and another one is picked meanwhile, to that one.

    Raises:
        Conflict: `stopped`: a stop was requested meanwhile.
        NotFound: Its docking server does not have the dock (`dock_not_found`).
    """
    actions = parts[ActionRegistry]
    action = await actions.find_docking(order.verb, order.robot, principal.grant)
    stops = action.delivery.stops
    await parts[Docks].require(action, order.request)
    if action.delivery.stops != stops:
        action.delivery.require_no_stop_since(stops)
    try:
        return action, await _submit(action, principal, order)
    except Unavailable:
        other = action if action.on_graph else await actions.find_docking(order.verb, order.robot, principal.grant)
        if other is action:
            raise
        action.delivery.require_no_stop_since(stops)
        return other, await _submit(other, principal, order)


async def _submit(action: Action, principal: Principal, order: SendGoal) -> Goal:
    acts_on(action.name)
    if order.action is None:
        message = action.read_docking_request(order.request, order.path)
    else:
        message = await action.read_goal(order.request, order.path)
    return await action.submitter.submit(message, order.key, sender=principal)


@dataclass(frozen=True)
class CancelGoal:
    """A goal to cancel, on any action and of any sender; `goal_id` is in its canonical form."""

    goal_id: str


@operation(Role.AGENT, Scope.GOAL, errors=(409, 504), stops=True)
async def cancel_goal(parts: Parts, _: Principal, order: CancelGoal) -> Goal:
    """Ask the action server to cancel a goal. Return the goal.

    Raises:
        NotAuthenticated: The login of who cancels it has ended meanwhile (`invalid_token`).
        NotFound: There is no such goal, or its action has no server.
        Conflict: The goal has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
        Unavailable: The action server is gone.
        ServerTimeout: The server did not answer in time.
    """
    goals = parts[Goals]
    goal = await goals.get(order.goal_id)
    require_unfinished(goal)
    action = await parts[ActionRegistry].find(goal.action_name)
    goal = await goals.get(order.goal_id)  # it may have returned or ended meanwhile
    await action.canceler.cancel(goal)
    return goal
