"""The JSON shapes of the commands of `/ws`, and of their answers."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, RootModel, WithJsonSchema, WrapValidator

from dock_gateway.core.goal import Verb
from dock_gateway.goals.schema import LiveGoal
from dock_gateway.http.schema import Schema
from dock_gateway.operations.battery import MAX_RATE, MIN_RATE
from dock_gateway.robots.schema import BatteryState, BatteryStateInput, Publisher
from dock_gateway.stop.order import STOP_REQUEST
from dock_gateway.stop.schema import LatchedStops, StopProblem, StopReport
from dock_gateway.streams.includes import Includes
from dock_gateway.streams.queries import MAX_RATE as MAX_EVENTS
from dock_gateway.streams.queries import MIN_RATE as MIN_EVENTS

MAX_ID = 200
NAMED = {"type": "string", "maxLength": MAX_ID}


def _adapt(schema: dict[str, Any]) -> None:
    """Require `op`, and leave out defaults: type generators treat a field that has one as always present."""
    schema["required"] = ["op", *schema.get("required", ())]
    for field in schema["properties"].values():
        field.pop("default", None)


class Command(Schema):
    """A command. Its `op` and `id` have been read when its other fields are."""

    model_config = ConfigDict(json_schema_extra=_adapt)

    id: Annotated[Any, WithJsonSchema({"anyOf": [NAMED, {"type": "null"}]})] = None


class SendGoalCommand(Command):
    """Send a goal to `action`, or a robot to its charging dock; with `verb` `undock` away from it."""

    op: Literal["send_goal"] = "send_goal"
    action: str | None = None
    verb: Verb | None = None
    robot: str | None = None
    goal: Annotated[Any, WithJsonSchema({"type": ["object", "null"], "additionalProperties": True})] = None
    idempotency_key: str | None = None


class CancelGoalCommand(Command):
    """Ask the action server to cancel a goal of any client."""

    op: Literal["cancel_goal"] = "cancel_goal"
    goal_id: str


class Include(RootModel[str]):
    """A type of events, or a group of them: `system` or `fleet`."""

    model_config = ConfigDict(json_schema_extra={"enum": [*Includes().names]})


class SubscribeCommand(Command):
    """Start a subscription, named by the `id` of the command. Its fields are the parameters of `/ws/feedback`.

    Each of its events has this id as `subscription`.
    """

    op: Literal["subscribe"] = "subscribe"
    id: Annotated[Any, WithJsonSchema(NAMED | {"minLength": 1})]
    goal_id: str | None = None
    action: str | None = None
    robot: str | None = None
    include: list[Include] | None = None
    after: str | None = None
    feedback: Annotated[Any, WithJsonSchema({"type": ["boolean", "null"]})] = None
    max_rate: Annotated[
        Any, WithJsonSchema({"type": ["number", "null"], "minimum": MIN_EVENTS, "maximum": MAX_EVENTS})
    ] = None


class UnsubscribeCommand(Command):
    """End a subscription."""

    op: Literal["unsubscribe"] = "unsubscribe"
    subscription: str


class PublishBatteryCommand(Command):
    """Publish a battery state once, or with `rate_hz` until it is stopped."""

    op: Literal["publish_battery"] = "publish_battery"
    robot: str | None = None
    state: Annotated[BatteryStateInput, WrapValidator(lambda value, _: value)] = BatteryStateInput()
    rate_hz: Annotated[Any, WithJsonSchema({"type": "number", "minimum": MIN_RATE, "maximum": MAX_RATE})] = None


class StopPublishingCommand(Command):
    """Stop publishing battery states."""

    op: Literal["stop_publishing"] = "stop_publishing"
    robot: str | None = None


class StopCommand(Command):
    """Stop robots, all by default, and cancel their goals. It is carried out whatever else it says."""

    op: Literal["stop"] = "stop"
    robot: Annotated[Any, WithJsonSchema(STOP_REQUEST["properties"]["robot"])] = None
    latch: Annotated[Any, WithJsonSchema(STOP_REQUEST["properties"]["latch"])] = True
    by: Annotated[Any, WithJsonSchema(STOP_REQUEST["properties"]["by"])] = None


class ReleaseStopCommand(Command):
    """Let robots that were stopped, all by default, move again."""

    op: Literal["release_stop"] = "release_stop"
    robot: str | None = None


class PingCommand(Command):
    """Answer with the time."""

    op: Literal["ping"] = "ping"


COMMAND_SCHEMAS: tuple[type[BaseModel], ...] = (
    SendGoalCommand,
    CancelGoalCommand,
    SubscribeCommand,
    UnsubscribeCommand,
    PublishBatteryCommand,
    StopPublishingCommand,
    StopCommand,
    ReleaseStopCommand,
    PingCommand,
)


class Ack(Schema):
    """A command was carried out; `id` is the command's."""

    op: Literal["ack"]
    id: str | None


class GoalAck(Ack):
    """The answer to `send_goal` and `cancel_goal`."""

    goal: LiveGoal


class PublisherAck(Ack):
    """The answer to `publish_battery` with a rate, and to `stop_publishing`."""

    battery_publisher: Publisher


class PublishedAck(Ack):
    """The answer to `publish_battery` without a rate: the message as published."""

    state: BatteryState


class StopAck(StopReport, Ack):
    """The answer to `stop`."""


class ReleaseAck(Ack):
    """The answer to `release_stop`."""

    stop: LatchedStops


class SubscriptionAck(Ack):
    """The answer to `subscribe` and `unsubscribe`."""

    subscription: str


class PingAck(Ack):
    """The answer to `ping`."""

    time: datetime


class CommandError(Schema):
    """A command was refused or failed. `id` is the command's, or that of a subscription that has ended by itself.

    `canceling`, `failed`, `unconfirmed` and `stop` of the error belong to `stop`.
    """

    op: Literal["error"]
    id: str | None
    error: StopProblem


# What a command is answered if it is not refused.
ANSWERS_TO: dict[str, tuple[type[Ack], ...]] = {
    "send_goal": (GoalAck,),
    "cancel_goal": (GoalAck,),
    "publish_battery": (PublisherAck, PublishedAck),
    "stop_publishing": (PublisherAck,),
    "stop": (StopAck,),
    "release_stop": (ReleaseAck,),
    "subscribe": (SubscriptionAck,),
    "unsubscribe": (SubscriptionAck,),
    "ping": (PingAck,),
}

ANSWERS: tuple[type[BaseModel], ...] = (
    *dict.fromkeys(answer for answers in ANSWERS_TO.values() for answer in answers),
    CommandError,
)
