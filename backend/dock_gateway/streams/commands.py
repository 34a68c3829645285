"""The commands of `/ws`, without the socket: a decoded message in, the fields of the ack out."""

from dock_gateway.access.carry_out import Command, Fields
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.goals.canceling import request_cancel
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import check_key, read_goal_id
from dock_gateway.robots.battery_routes import read_rate
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.stop.order import STOP_SERVICE, StopOrder, releases_stop, stops_robots
from dock_gateway.stop.routes import stop_robots
from dock_gateway.stop.stopper import Stopper
from dock_gateway.streams.command_schema import (
    MAX_ID,
    CancelGoalCommand,
    PingCommand,
    PublishBatteryCommand,
    ReleaseStopCommand,
    SendGoalCommand,
    StopPublishingCommand,
)

STOP = "stop"
# Commands that other protocols have as services.
OWN_SERVICES = {STOP_SERVICE: STOP, "/dock_gateway/release_stop": "release_stop"}


def read_command(message: object) -> tuple[str, str | None, Fields]:
    """Return the op, id and other fields of a decoded message.

    Raises:
        InvalidField: The message is not a command.
    """
    if not isinstance(message, dict):
        raise InvalidField([FieldError("", "an object with op", "got something else")])
    fields = dict(message)
    op, identity = fields.pop("op", None), fields.pop("id", None)
    if not isinstance(op, str):
        raise InvalidField([FieldError("op", "a string", "got none" if op is None else "got something else")])
    if identity is not None and (not isinstance(identity, str) or len(identity) > MAX_ID):
        if op == STOP:  # carried out anyway, with a warning about the unknown field
            return op, None, {**fields, "id": identity}
        raise InvalidField([FieldError("id", f"a string of at most {MAX_ID} characters", "got something else")])
    return op, identity, fields


@operation(Role.AGENT, Scope.NEW_GOAL, sends_goal=True)
async def send_goal(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Send a goal to `action`, or a robot to its charging dock. The ack has the goal."""
    command = read_fields(SendGoalCommand, fields)
    if command.action is not None:
        return await _submit_goal(parts, principal, command)
    with parts[RobotActions].hinting(command.robot, principal.grant):
        return await _submit_goal(parts, principal, command)


async def _submit_goal(parts: Parts, principal: Principal, command: SendGoalCommand) -> Fields:
    name, robot, goal = command.action, command.robot, command.goal
    if name is None:
        action = await parts[RobotActions].find("dock", robot, principal.grant)
        message = action.parse_request(action.default_request if goal is None else goal, "goal")
    else:
        namespace = None if robot is None else parts[RobotRegistry].get(robot).namespace
        action = await parts[ActionRegistry].find(parts[Settings].resolve(name, namespace))
        message = await action.read_goal(goal, "goal")
    key = check_key(command.idempotency_key, "idempotency_key")
    own = None if key is None else principal.own(key)
    return {"goal": (await action.submitter.submit(message, own)).document()}


@operation(Role.AGENT, Scope.GOAL)
async def cancel_goal(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Ask the action server to cancel a goal, whoever sent it."""
    command = read_fields(CancelGoalCommand, fields)
    goal = await request_cancel(parts[Goals], parts[ActionRegistry], read_goal_id(command.goal_id))
    return {"goal": goal.document()}


@operation(Role.SUPERVISOR, Scope.ROBOT)
async def publish_battery(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Publish a battery state once, or with `rate_hz` until it is stopped."""
    command = read_fields(PublishBatteryCommand, fields)
    publisher, state = parts[RobotRegistry].get(command.robot).publisher, fields.get("state", {})
    if "rate_hz" in fields:
        await publisher.start(state, read_rate(command.rate_hz))
        return {"battery_publisher": publisher.document()}
    return {"state": fragment(await publisher.publish(state, "state"))}


@operation(Role.SUPERVISOR, Scope.ROBOT)
async def stop_publishing(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Stop publishing battery states."""
    command = read_fields(StopPublishingCommand, fields)
    publisher = parts[RobotRegistry].get(command.robot).publisher
    await publisher.stop()
    return {"battery_publisher": publisher.document()}


@stops_robots
async def stop(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Stop robots, all by default, and cancel their goals."""
    order: StopOrder = fields["order"]
    return await stop_robots(parts[Stopper], principal, order)


@releases_stop
async def release_stop(parts: Parts, _: Principal, fields: Fields) -> Fields:
    """Let robots that were stopped, all by default, move again."""
    return {"stop": await parts[Stopper].release(read_fields(ReleaseStopCommand, fields).robot)}


@operation(Role.VIEWER, Scope.ANY, Audit.NEVER)
async def ping(_: Parts, __: Principal, fields: Fields) -> Fields:
    """Answer with the time."""
    read_fields(PingCommand, fields)
    return {"time": utc_now()}


# By their names, which are those of the functions.
COMMANDS: dict[str, Command] = {
    command.__name__: command
    for command in (send_goal, cancel_goal, publish_battery, stop_publishing, stop, release_stop, ping)
}
