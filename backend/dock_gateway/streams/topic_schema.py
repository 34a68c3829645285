"""The JSON shapes of the events of `/ws/topics`."""

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel

from dock_gateway.graph.schema import GraphTopic
from dock_gateway.http.schema import Schema
from dock_gateway.streams.schema import ClosingEvent, DroppedEvent


class TopicEvent(Schema):
    """The topic and its endpoints: the first message of a stream, sent again when they change.

    If messages cannot be read, for example because their package is not `installed`, `hint` says what to do.
    """

    type: Literal["topic"]
    time: datetime
    topic: GraphTopic
    message_type: str
    installed: bool
    hint: str | None


class MessageEvent(Schema):
    """A message on the topic; `time` is when it was published.

    If it is `abbreviated`, long arrays are cut to 100 items and long texts to 10,000 characters. `lengths` holds their
    original lengths by dotted field path.
    """

    type: Literal["message"]
    time: datetime
    topic: str
    message: dict[str, Any]
    abbreviated: bool
    lengths: dict[str, int]


class RateEvent(Schema):
    """The topic's rate over the last 3 s; `messages` counts all messages since it was first watched."""

    type: Literal["rate"]
    time: datetime
    topic: str
    rate_hz: float
    bytes_per_s: int
    messages: int


class TopicHeartbeatEvent(Schema):
    """The stream is alive."""

    type: Literal["heartbeat"]
    time: datetime


ECHO_EVENTS: tuple[type[BaseModel], ...] = (
    TopicEvent,
    MessageEvent,
    RateEvent,
    TopicHeartbeatEvent,
    DroppedEvent,
    ClosingEvent,
)
