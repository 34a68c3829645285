"""The JSON shapes of the answers to the commands of `/ws`."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel

from dock_gateway.goals.schema import ActionGoal
from dock_gateway.http.schema import Schema
from dock_gateway.robots.schema import BatteryState, Publisher
from dock_gateway.stop.schema import StopProblem, StopReport, StopState


class Ack(Schema):
    """A command was carried out; `id` is the command's."""

    op: Literal["ack"]
    id: str | None


class GoalAck(Ack):
    """The answer to `send_goal` and `cancel_goal`."""

    goal: ActionGoal


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

    stop: StopState


class SubscriptionAck(Ack):
    """The answer to `subscribe` and `unsubscribe`."""

    subscription: str


class PingAck(Ack):
    """The answer to `ping`."""

    time: datetime


class CommandError(StopProblem):
    """A command was refused or failed. `canceling`, `failed`, `unconfirmed` and `stop` belong to `stop`."""

    op: Literal["error"]
    id: str | None


ANSWERS: tuple[type[BaseModel], ...] = (
    GoalAck,
    PublisherAck,
    PublishedAck,
    StopAck,
    ReleaseAck,
    SubscriptionAck,
    PingAck,
    CommandError,
)
