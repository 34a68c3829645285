"""Events that the fan-out sends to subscribers, each encoded only once. Plain functions of plain data.

An event's id starts with the ROS source timestamp of the message that caused it, which is the same for every reader on
the network: nanoseconds, padded so that ids sort as text. The event's kind and its subject follow.
"""

import hashlib
import re
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from functools import cached_property
from typing import Any, NamedTuple

from dock_gateway.core.goal import Goal, GoalStatus, encode, fragment
from dock_gateway.core.grant import Grant

# Returns what a grant covers of the document of an event about several robots; None if that is nothing.
Narrow = Callable[[dict[str, Any], Grant], dict[str, Any] | None]


@dataclass(frozen=True)
class Event:
    """An encoded event and its routing data.

    `topic` is `goals`, or the event's type, which `?include=` names. Only `droppable` events may be dropped for a slow
    subscriber. `id` is the document's id, if it has one. `robot` is the namespace of the robot, if the event is about
    one robot. `ends_goal`: no further events of the goal are expected. `supersedes`: the event replaces a queued one of
    the same topic and robot. `key` identifies what happened and is the same at every gateway, so the history stores it
    once. A goal has one end and one result. `source` is the ROS topic that it was read from, if readers need the right
    to read that, too. `narrow` says what a limited reader is shown of an event about several robots, which has no `id`:
    the history, from which readers resume, stores no functions.

    Raises:
        ValueError: The event has both an `id` and `narrow`.
    """

    data: bytes
    topic: str
    goal_id: str | None = None
    action_name: str | None = None
    droppable: bool = False
    id: str | None = None
    robot: str | None = None
    ends_goal: bool = False
    supersedes: bool = False
    key: str | None = None
    source: str | None = None
    narrow: Narrow | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.narrow is not None and self.id is not None:
            raise ValueError(f"the event {self.id} about several robots must have no id")

    @cached_property
    def sse(self) -> bytes:
        """The event in Server-Sent Events format."""
        identity = b"" if self.id is None else b"id: " + self.id.encode() + b"\n"
        return identity + b"data: " + self.data + b"\n\n"

    @cached_property
    def frame(self) -> bytes:
        """The event as an uncompressed WebSocket frame from a server."""
        return websocket_frame(self.data)

    @cached_property
    def text(self) -> str:
        """The data as a WebSocket text message."""
        return self.data.decode()


def websocket_frame(data: bytes, *, binary: bool = False) -> bytes:
    """Return an uncompressed WebSocket frame from a server (RFC 6455, section 5.2)."""
    first, size = 0x82 if binary else 0x81, len(data)
    if size < 126:
        return struct.pack("!BB", first, size) + data
    if size < 65_536:
        return struct.pack("!BBH", first, 126, size) + data
    return struct.pack("!BBQ", first, 127, size) + data


EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
# The kind in the id of a goal's event, by the event's type.
STATUS, FEEDBACK, RESULT = "s", "f", "z"
KINDS = {"status": STATUS, "feedback": FEEDBACK, "result": RESULT}
# Those of a goal that the history has: poses are stored, but not sent on streams.
POSE = "p"
STORED_KINDS = KINDS | {"pose": POSE}
STAMP_DIGITS = 20
# Maximum difference between the clocks of two gateways, in nanoseconds.
CLOCK_TOLERANCE = 5_000_000_000
KIND_AT = STAMP_DIGITS + 1
# Digits of the digest that a position has in place of a goal's id or a robot's namespace.
POSITION_DIGITS = 16
POSITION = re.compile(rf"([0-9]{{{STAMP_DIGITS}}}-[A-Za-z_]+-)[0-9a-f]{{{POSITION_DIGITS}}}")
# Sorts after the id of every event.
NEVER = "~"


class EventClock:
    """Stamps events so that their ids grow in order of publication: a reader resumes after the last one it received.

    The stamp is the source timestamp of the message where possible, as that is the same at every gateway. A timestamp
    ahead of this machine's clock is reduced to it; one not later than the previous stamp becomes that stamp plus 1 ns.

    Args:
        newest: Id of the newest stored event, as this machine's clock may have been set back.
    """

    def __init__(self, newest: str = "") -> None:
        self._last = max(time.time_ns(), stamp_of(newest) if newest else 0)

    def stamp(self, source_ns: int) -> int:
        """Return the stamp for an event that is published now, in nanoseconds since 1970."""
        self._last = max(min(source_ns, time.time_ns()), self._last + 1)
        return self._last

    def pass_by(self, event_id: str) -> None:
        """Stamp all further events later than this one, which another gateway may have stamped."""
        self._last = max(self._last, stamp_of(event_id))

    def is_past(self, event_id: str) -> bool:
        """Return whether an event with this id can have been published by now, here or at another gateway."""
        return stamp_of(event_id) <= max(self._last, time.time_ns() + CLOCK_TOLERANCE)


def event_id(stamp_ns: int, kind: str, subject: str) -> str:
    """Return the id of an event, sortable as text. `subject` is a goal's id or a robot's namespace."""
    return f"{time_id(stamp_ns)}-{kind}-{subject}"


def position_of(identity: str) -> str:
    """Return the position of an event, for any reader: its id, but for what it is about, which not everyone may see."""
    stamp, kind, _ = identity.split("-", 2)
    return f"{stamp}-{kind}-{hashlib.sha256(identity.encode()).hexdigest()[:POSITION_DIGITS]}"


def restamped(event: Event, stamp_ns: int) -> Event:
    """Return an event with another stamp in its id, also where its document repeats that (`last_event_id`)."""
    before = event.id or ""
    after = time_id(stamp_ns) + before[STAMP_DIGITS:]
    return replace(event, id=after, data=event.data.replace(before.encode(), after.encode()))


def stamp_of(identity: str) -> int:
    """Return the time in an event's id, in nanoseconds since 1970."""
    return int(identity[:STAMP_DIGITS])


def time_id(stamp_ns: int) -> str:
    """Return the prefix of the ids of events at a time."""
    return f"{stamp_ns:0{STAMP_DIGITS}d}"


def kind_of(identity: str) -> str:
    """Return the kind in the id of a goal's event: one of `KINDS`."""
    return identity[KIND_AT : KIND_AT + 1]


def nanoseconds(time: datetime) -> int:
    """Convert a time to a ROS timestamp, nanoseconds since 1970."""
    return (time - EPOCH) // timedelta(microseconds=1) * 1000


def utc_now() -> datetime:
    """Return the current UTC time."""
    return datetime.now(UTC)


class Now(NamedTuple):
    """The time: nanoseconds since 1970, and seconds on the monotonic clock."""

    ns: int
    monotonic: float

    @classmethod
    def read(cls) -> "Now":
        """Return the current time."""
        return cls(time.time_ns(), time.monotonic())


def moment(stamp_ns: int) -> datetime:
    """Convert a ROS timestamp, nanoseconds since 1970, to a UTC time, rounded down to the microsecond."""
    return EPOCH + timedelta(microseconds=stamp_ns // 1000)


def status_event(goal: Goal, stamp_ns: int, source_ns: int | None = None) -> Event:
    """Return the event of a change of the goal's state.

    Args:
        goal: The goal as it is now. Its `last_event_id` is set to the event's id.
        stamp_ns: The stamp in the event's id, in nanoseconds.
        source_ns: When it happened, by the clock of the message that reported it, in nanoseconds; default `stamp_ns`.
    """
    ends_goal = goal.status is GoalStatus.LOST  # it may come back, but nothing says when
    once = goal.status.final
    return _goal_event("status", goal, stamp_ns, source_ns, goal.summary, once=once, ends_goal=ends_goal)


def feedback_event(goal: Goal, stamp_ns: int, source_ns: int | None = None) -> Event:
    """Return the event of the goal's current feedback; arguments as for `status_event`."""
    return _goal_event(
        "feedback", goal, stamp_ns, source_ns, lambda: {"feedback": fragment(goal.feedback)}, droppable=True
    )


def result_event(goal: Goal, stamp_ns: int, source_ns: int | None = None) -> Event:
    """Return the event of the goal's end. Without a result from the server it is null. Arguments as `status_event`."""
    payload = {"status": goal.status.value, "result": fragment(goal.result), "error": goal.error}
    return _goal_event("result", goal, stamp_ns, source_ns, lambda: payload, once=True, ends_goal=True)


def is_end(event: Event) -> bool:
    """Return whether an event of a goal tells its end: its last state, or its result."""
    return event.key in (f"{STATUS}-{event.goal_id}", f"{RESULT}-{event.goal_id}")


def _goal_event(
    kind: str,
    goal: Goal,
    stamp_ns: int,
    source_ns: int | None,
    payload: Callable[[], dict[str, Any]],
    *,
    once: bool = False,
    droppable: bool = False,
    ends_goal: bool = False,
) -> Event:
    source_ns = stamp_ns if source_ns is None else source_ns
    goal.last_event_id = event_id(stamp_ns, KINDS[kind], goal.goal_id)
    head = {
        "type": kind,
        "id": goal.last_event_id,
        "time": moment(source_ns),
        "goal_id": goal.goal_id,
        "action_name": goal.action_name,
    }
    what = KINDS[kind] if once or droppable else f"{KINDS[kind]}-{goal.status.value}"
    return Event(
        encode(head | payload()),
        "goals",
        goal.goal_id,
        goal.action_name,
        droppable,
        id=goal.last_event_id,
        ends_goal=ends_goal,
        key=f"{what}-{goal.goal_id}" if once else event_id(source_ns, what, goal.goal_id),
    )


def pose_event(goal: Goal, scene: dict[str, Any], stamp_ns: int, source_ns: int) -> Event:
    """Return the event with the poses of a robot and its dock while a goal runs. Arguments as for `status_event`."""
    identity = event_id(stamp_ns, POSE, goal.goal_id)
    document = {
        "type": "pose",
        "id": identity,
        "time": moment(source_ns),
        "goal_id": goal.goal_id,
        "action_name": goal.action_name,
        "scene": scene,
    }
    return Event(encode(document), "poses", goal.goal_id, goal.action_name, droppable=True, id=identity, key=identity)


def robot_event(kind: str, payload: object, stamp_ns: int, source_ns: int | None = None, *, robot: str = "/") -> Event:
    """Return the event of a message on a robot's topic, `battery` or `cmd_vel`. Stamps as for `status_event`."""
    source_ns = stamp_ns if source_ns is None else source_ns
    identity = event_id(stamp_ns, kind, robot)
    document = {"type": kind, "id": identity, "time": moment(source_ns), "robot": robot, kind: payload}
    key = event_id(source_ns, kind, robot)
    return Event(encode(document), kind, droppable=True, id=identity, robot=robot, key=key)


def scene_event(scene: dict[str, Any], now: datetime, *, robot: str) -> Event:
    """Return the event with the poses of a robot and its dock. Only the newest matters; none is stored."""
    document = {"type": "scene", "time": now, "robot": robot, "scene": scene}
    return Event(encode(document), "scene", droppable=True, robot=robot, supersedes=True)


def overview_event(kind: str, payload: dict[str, dict[str, Any]], now: datetime, narrow: Narrow) -> Event:
    """Return an event about all robots, by robot, such as `scenes`. Only the newest matters; none is stored."""
    document = {"type": kind, "time": now, kind: payload}
    return Event(encode(document), kind, droppable=True, supersedes=True, narrow=narrow)


def system_event(
    kind: str, payload: object, now: datetime, *, robot: str | None = None, action_name: str | None = None
) -> Event:
    """Return a system event: `battery_publisher`, `docking` or `simulator` of a robot, or `action_server`."""
    document = {"type": kind, "time": now, kind: payload} | ({} if robot is None else {"robot": robot})
    return Event(encode(document), kind, robot=robot, action_name=action_name)


def stop_event(state: object, stamp_ns: int | None, *, robot: str) -> Event:
    """Return the event of a stop or its release. Without a stamp it is the present state: nothing that has happened.

    Readers who resume get it, so that no stop that was released meanwhile is missed.
    """
    identity = None if stamp_ns is None else event_id(stamp_ns, "stop", robot)
    now = utc_now() if stamp_ns is None else moment(stamp_ns)
    document = {"type": "stop", "id": identity, "time": now, "robot": robot, "stop": state}
    return Event(encode(document), "stop", id=identity, robot=robot, key=identity)


def loss_event(goal_id: str, action_name: str, why: str, count: int, now: datetime) -> Event:
    """Return the event of feedback that was not read: `feedback_too_large` or `feedback_too_fast`."""
    document = {
        "type": "feedback_dropped",
        "time": now,
        "goal_id": goal_id,
        "action_name": action_name,
        "reason": f"feedback_{why}",
        "count": count,
    }
    return Event(encode(document), "goals", goal_id, action_name)


def fleet_event(kind: str, now: datetime, narrow: Narrow, **payload: Any) -> Event:
    """Return the event of a change in the fleet: `robots` holds those that changed, `alerts` all alerts."""
    return Event(encode({"type": kind, "time": now, **payload}), kind, narrow=narrow)


def notice(kind: str, now: datetime, *, ends_goal: bool = False, position: str | None = None, **payload: Any) -> Event:
    """Return a stream's message about itself: `snapshot`, `resumed`, `gap`, `heartbeat`, `dropped`, `closing`.

    Args:
        kind: Its type.
        now: When it is sent.
        ends_goal: As for `Event`.
        position: Id of the last event before it: all later ones follow it. It is the message's id, too.
        payload: Further fields.
    """
    identity = {} if position is None else {"id": position}
    return Event(encode({"type": kind, **identity, "time": now, **payload}), "notice", id=position, ends_goal=ends_goal)
