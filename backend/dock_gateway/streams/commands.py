"""The commands that every door but REST has: decoded fields in, the fields of the answer out. `/ws` has them all."""

from dock_gateway.access.carry_out import Command, Fields
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.operation import Audit, Scope, carries_out, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import check_key, read_goal_id
from dock_gateway.operations import battery, goals
from dock_gateway.operations import stop as stopping
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.stop.order import STOP_SERVICE, StopOrder
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


@carries_out(goals.send_goal)
async def send_goal(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Send a goal to `action`, or a robot to its charging dock or away from it. The ack has the goal."""
    command = read_fields(SendGoalCommand, fields)
    if command.action is not None and command.verb is not None:
        raise InvalidField([FieldError("verb", "either an action or a verb", "got both")])
    name, robot = command.action, command.robot
    key = check_key(command.idempotency_key, "idempotency_key")
    if name is not None:
        namespace = None if robot is None else parts[RobotRegistry].get(robot).namespace
        name = parts[Settings].resolve(name, namespace)
    own_key = None if key is None else principal.own(key)
    order = goals.SendGoal(command.goal, name, command.verb or "dock", robot, own_key, path="goal")
    _, sent = await goals.send_goal(parts, principal, order)
    return {"goal": sent.document()}


@carries_out(goals.cancel_goal)
async def cancel_goal(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Ask the action server to cancel a goal, whoever sent it."""
    command = read_fields(CancelGoalCommand, fields)
    goal = await goals.cancel_goal(parts, principal, goals.CancelGoal(read_goal_id(command.goal_id)))
    return {"goal": goal.document()}


@carries_out(battery.publish_battery)
async def publish_battery(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Publish a battery state once, or with `rate_hz` until it is stopped."""
    command, state = read_fields(PublishBatteryCommand, fields), fields.get("state", {})
    if "rate_hz" in fields:
        start = battery.StartPublishing(state, command.rate_hz, command.robot)
        return {"battery_publisher": (await battery.start_publishing(parts, principal, start)).document()}
    order = battery.PublishBattery(state, command.robot, "state")
    return {"state": fragment(await battery.publish_battery(parts, principal, order))}


@carries_out(battery.stop_publishing)
async def stop_publishing(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Stop publishing battery states."""
    command = read_fields(StopPublishingCommand, fields)
    return {"battery_publisher": (await battery.stop_publishing(parts, principal, command.robot)).document()}


@carries_out(stopping.stop)
async def stop(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Stop robots, all by default, and cancel their goals."""
    order: StopOrder = fields["order"]
    return await stopping.stop(parts, principal, order)


@carries_out(stopping.release_stop)
async def release_stop(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Let robots that were stopped, all by default, move again."""
    command = read_fields(ReleaseStopCommand, fields)
    return {"stop": await stopping.release_stop(parts, principal, command.robot)}


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
