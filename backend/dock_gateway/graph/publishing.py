"""Publishes messages on any topic of the ROS graph that the setting `allow_publish` allows.

A message may do anything, also move a robot past goals and the latch. So nothing is published on a topic that the
setting does not name, and while a robot is stopped, only what cannot command it.
"""

import asyncio
import time
from collections import OrderedDict
from dataclasses import dataclass
from math import isfinite
from typing import Any

from dock_gateway.core.allow_list import AllowList
from dock_gateway.core.errors import FieldError, InvalidField, Unavailable, got, use_other_request
from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import Json
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.graph import ACTION_PART, Topic
from dock_gateway.core.request import act
from dock_gateway.core.work import SMALL, in_turn
from dock_gateway.graph.names import choose_type, not_found, not_installed
from dock_gateway.latch.interlock import Interlock
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import TOPIC_NAME, read_topic, topic_names
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_message
from dock_gateway.ros.messages.types import MessageClass
from dock_gateway.ros.topic_port import TopicPort
from dock_gateway.setting_types import LONGEST_NAME
from dock_gateway.settings import Settings
from robot_io import velocity_types

# Publishers that are kept for the next message, and the seconds for which one is kept.
MAX_PUBLISHERS, KEEP = 50, 60.0
# Seconds between two checks of the types of a topic that is published on.
CHECK_INTERVAL = 1.0
# What a velocity consists of.
PARTS = ("linear", "angular")
# Messages that command nothing: published for stopped robots, too.
REPORTS = frozenset({"sensor_msgs/msg/BatteryState", "diagnostic_msgs/msg/DiagnosticArray"})


@dataclass(frozen=True)
class FoundTopic:
    """A topic and the type that is published on it.

    Attributes:
        name: Absolute name.
        type: The type.
        types: The types that others have there, none if no one is there.
        latched: Whether a subscriber asks for earlier messages.
        subscribers: The number of its subscriptions.
    """

    name: str
    type: str
    types: tuple[str, ...]
    latched: bool
    subscribers: int

    @property
    def reports(self) -> bool:
        """Whether its messages command nothing."""
        return self.type in REPORTS


@dataclass
class Publication:
    """A publisher that is kept.

    Attributes:
        topic: What it publishes on, when that was checked last.
        kind: The message class.
        port: The publisher.
        checked_at: When the topic was checked last, on the monotonic clock.
        used: When it published last.
        reached: Done when the subscribers that were there are reached; canceled when the publisher leaves before.
    """

    topic: FoundTopic
    kind: MessageClass
    port: TopicPort
    checked_at: float
    used: float
    reached: "asyncio.Task[None]"

    def serves(self, type_name: str | None) -> bool:
        """Whether it publishes this type, and its topic was checked a short time ago."""
        return type_name in (None, self.topic.type) and time.monotonic() - self.checked_at < CHECK_INTERVAL


@dataclass(frozen=True)
class SentMessage:
    """A message that was published, its type, its class, and the number of subscriptions that it reached."""

    type: str
    subscribers: int
    kind: MessageClass
    message: Any

    async def encode(self, size: int) -> Json:
        """Return the message as JSON, in a thread if it is large; `size` is the number of bytes that it had as such."""
        encode = codec(self.kind).encode
        return encode(self.message) if size <= SMALL else await in_turn(encode, self.message)


class Publishing:
    """Publishes messages. Who uses it has checked that the user's grant covers the topic (`Grant.covers_publishing`).

    Args:
        settings: The topics that may be published on, and those of stops and velocities.
        bridge: The bridge to the ROS thread.
        interlock: Which robots are stopped.

    Attributes:
        listed: The topics that may be published on.
    """

    def __init__(self, settings: Settings, bridge: Bridge, interlock: Interlock) -> None:
        self._settings = settings
        self._bridge = bridge
        self._interlock = interlock
        self.listed = AllowList("allow_publish", settings.allow_publish, "the gateway does not publish on")
        self._publications: OrderedDict[str, Publication] = OrderedDict()
        self._opening = asyncio.Lock()

    def require_allowed(self, name: str) -> None:
        """Refuse a topic that may not be published on.

        Raises:
            NotAllowed: It is not in the setting (`not_allowed`), or it is a topic of an action or of stops
                (`use_other_request`), which no setting allows.
        """
        if ACTION_PART in name:
            action = name.partition(ACTION_PART)[0]
            raise use_other_request(
                f"{name[:200]} belongs to an action, and only its server publishes it",
                f"POST /actions{action[:200]}/goals",
            )
        if any(name == stop or (stop[0] != "/" and name.endswith(f"/{stop}")) for stop in self._stop_topics):
            raise use_other_request(f"{name[:200]} tells whether a robot is stopped", "POST /stop")
        self.listed.require(name)

    @property
    def _stop_topics(self) -> tuple[str, ...]:
        return (self._settings.stop_state_topic, *self._settings.emergency_stop_topics)

    async def find(self, name: str, type_name: str | None = None, grant: Grant = UNLIMITED) -> FoundTopic:
        """Return a topic and the type to publish on it.

        Args:
            name: Absolute name.
            type_name: The type; needed if no one is there, or if others have several types.
            grant: What the user may see of the graph.

        Raises:
            NotFound: `topic_not_found`, with similar names: no one is there, and no type is given.
            InvalidField: The name is none, or `type_name` is not a type of the topic, or it is missing and needed.
            Unavailable: `ros_unavailable`.
        """
        if not TOPIC_NAME.fullmatch(name) or len(name) > LONGEST_NAME:
            raise InvalidField([FieldError("topic", "a name on the ROS graph", f"got {name[:60]!r}")])
        node = self._bridge.node
        topic = await self._bridge.call(lambda: read_topic(node, name))
        types = sorted(topic.types_but_of({node.get_fully_qualified_name()})) or topic.types
        if not types and type_name is None:
            known = await self._bridge.call(lambda: topic_names(node))
            raise not_found("topic", name, filter(grant.covers_topic, known))
        chosen = choose_type(name, types, type_name) if types else str(type_name)
        return FoundTopic(name, chosen, tuple(types), *_wishes(topic, chosen))

    async def publish(
        self, name: str, fields: object, *, type_name: str | None = None, grant: Grant = UNLIMITED
    ) -> SentMessage:
        """Publish one message. Its publisher is kept for a minute, for the next one.

        Args:
            name: Absolute name of the topic.
            fields: The message, as decoded JSON; fields that are left out get their default.
            type_name: The type; needed if no one is there, or if others have several types.
            grant: What the user may see of the graph.

        Raises:
            NotAllowed: As for `require_allowed`.
            NotFound, InvalidField: As for `find`; or `fields` are not a message of this type.
            Conflict: `stop_latched`: the robot is stopped, and the message may command it; or `topic_in_use`.
            NotInstalled: The package of its type is missing.
            Unavailable: `ros_unavailable`; also if its publisher has left since.
        """
        self.require_allowed(name)
        publication, message = self._publications.get(name), fields
        if publication is None or not publication.serves(type_name):
            publication, message = await self._open(name, type_name, grant, fields)
        message = await _read(publication.topic, publication.kind, message)
        if not publication.reached.done():
            await asyncio.wait({publication.reached})
        # Nothing is awaited from here on, so no stop can come between the check and the message.
        act()
        self._require_released(publication.topic)
        if not publication.port.open:
            raise Unavailable(f"the publisher of {name} has left meanwhile: try again", code="ros_unavailable")
        publication.port.publish(message)
        publication.used = time.monotonic()
        return SentMessage(publication.topic.type, publication.port.subscribers, publication.kind, message)

    async def _open(self, name: str, type_name: str | None, grant: Grant, fields: object) -> tuple[Publication, object]:
        topic = await self.find(name, type_name, grant)
        kind = await self.load(topic)
        message = await _read(topic, kind, fields)  # before the gateway appears on the topic
        self._require_released(topic)
        async with self._opening:
            known = self._publications.get(name)
            if known is None or known.topic.type != topic.type or topic.latched > known.topic.latched:
                known = await self._replace(topic, kind)
            known.topic, known.checked_at = topic, time.monotonic()
        return known, message

    async def _replace(self, topic: FoundTopic, kind: MessageClass) -> Publication:
        self._drop(topic.name)
        while len(self._publications) >= MAX_PUBLISHERS:
            self._drop(next(iter(self._publications)))
        port = await self._bridge.call(
            lambda: TopicPort(self._bridge, topic.name, kind, latched=topic.latched), undo=TopicPort.close
        )
        now = time.monotonic()
        reached = asyncio.create_task(port.reach(topic.subscribers))
        new = self._publications[topic.name] = Publication(topic, kind, port, now, now, reached)
        asyncio.get_running_loop().call_later(KEEP, self._expire, new)
        return new

    @staticmethod
    async def load(topic: FoundTopic) -> MessageClass:
        """Return the Python class of a topic's type.

        Raises:
            NotInstalled: The package of its type is missing.
        """

        def load() -> MessageClass:
            kind = load_message(topic.type)
            codec(kind)
            return kind

        try:
            return await asyncio.to_thread(load)
        except (ImportError, TypeError) as error:
            raise not_installed(topic.name, topic.type, error) from None

    def _require_released(self, topic: FoundTopic) -> None:
        if topic.reports:
            return
        what = "messages on its topics"
        self._interlock.require_released(topic.name, what)
        if topic.name == self._settings.cmd_vel_topic:  # an absolute name: that of every robot
            for robot in self._interlock.held:
                self._interlock.require_released(robot, what)

    def withdraw(self, robot: str) -> None:
        """Leave the topics of a robot that is stopped, so that nothing that was published before reaches it late."""
        for name, publication in [*self._publications.items()]:
            commands = not publication.topic.reports
            if commands and (is_under(name, robot) or name == self._settings.cmd_vel_topic):
                self._drop(name)

    def _expire(self, publication: Publication) -> None:
        if not publication.port.open:
            return
        left = publication.used + KEEP - time.monotonic()
        if left > 0:
            asyncio.get_running_loop().call_later(left, self._expire, publication)
        else:
            self._drop(publication.topic.name)

    def _drop(self, name: str) -> None:
        publication = self._publications.pop(name, None)
        if publication is not None:
            publication.reached.cancel()
            publication.port.close()

    async def close(self) -> None:
        """Leave all topics."""
        for name in [*self._publications]:
            self._drop(name)


async def _read(topic: FoundTopic, kind: MessageClass, fields: object) -> Any:
    """Return a message; a velocity has to be finite: what a base does with NaN is not known.

    Raises:
        InvalidField: It is no such message.
    """
    message = await codec(kind).read(fields)
    if topic.type in velocity_types.TYPES:
        twist, path = (message.twist, "twist.") if topic.type == velocity_types.STAMPED else (message, "")
        values = {f"{path}{part}.{axis}": getattr(getattr(twist, part), axis) for part in PARTS for axis in "xyz"}
        wrong = [
            FieldError(name, "a finite number", got(value)) for name, value in values.items() if not isfinite(value)
        ]
        if wrong:
            raise InvalidField(wrong)
    return message


def _wishes(topic: Topic, type_name: str) -> tuple[bool, int]:
    """Return whether a subscriber asks for earlier messages, and how many subscribers there are."""
    subscribers = [endpoint for endpoint in topic.subscribers if endpoint.type == type_name]
    return any(endpoint.qos.durability == "transient_local" for endpoint in subscribers), len(subscribers)
