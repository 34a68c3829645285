"""Events: what the hub sends to subscribers, encoded once however many there are. Plain functions of plain data.

An event's id is built on the ROS source timestamp of the message that caused it, which is the same at every reader on
the network: nanoseconds, padded so that ids sort as text, then what it is and whose it is.
"""

import struct
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cached_property
from typing import Any

from dock_gateway.goals import Goal, GoalStatus, Json, encode, fragment


@dataclass(frozen=True)
class Event:
    """An encoded event and what is needed to route it.

    `topic` is `goals`, or what `?include=` names: `battery`, `cmd_vel`, `system`, `scene`, `robots`. Only `droppable`
    ones may be lost to a slow subscriber. `id` is that of the document, where it has one; `robot` the namespace it is
    about, where that is one robot. `ends_goal`: nothing more is to be expected of the goal. `supersedes`: who has not
    been sent the one before of its topic and robot does not get it any more.
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

    @cached_property
    def sse(self) -> bytes:
        """The event as Server-Sent Events have it."""
        identity = b"" if self.id is None else b"id: " + self.id.encode() + b"\n"
        return identity + b"data: " + self.data + b"\n\n"

    @cached_property
    def frame(self) -> bytes:
        """The event as a WebSocket frame, from a server and without compression: RFC 6455, section 5.2."""
        size = len(self.data)
        if size < 126:
            return struct.pack("!BB", 0x81, size) + self.data
        if size < 65_536:
            return struct.pack("!BBH", 0x81, 126, size) + self.data
        return struct.pack("!BBQ", 0x81, 127, size) + self.data

    @cached_property
    def text(self) -> str:
        """The data as a WebSocket text message has it."""
        return self.data.decode()


EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
# What the id of a goal's event says it is, by the event's type.
STATUS, FEEDBACK, RESULT = "s", "f", "z"
KINDS = {"status": STATUS, "feedback": FEEDBACK, "result": RESULT}
STAMP_DIGITS = 20
KIND_AT = STAMP_DIGITS + 1


def event_id(stamp_ns: int, kind: str, goal_id: str = "") -> str:
    """The id of an event, sortable as text."""
    return f"{time_id(stamp_ns)}-{kind}{goal_id[:8]}"


def time_id(stamp_ns: int) -> str:
    """What the ids of events at a time begin with."""
    return f"{stamp_ns:0{STAMP_DIGITS}d}"


def kind_of(identity: str) -> str:
    """What the id of a goal's event says it is: one of `KINDS`."""
    return identity[KIND_AT : KIND_AT + 1]


def nanoseconds(time: datetime) -> int:
    """A time as a ROS timestamp, nanoseconds since 1970."""
    return (time - EPOCH) // timedelta(microseconds=1) * 1000


def utc_now() -> datetime:
    """The time now."""
    return datetime.now(UTC)


def moment(stamp_ns: int) -> datetime:
    """A ROS timestamp, nanoseconds since 1970, as a UTC time: the microsecond that it is in, never the next one."""
    return EPOCH + timedelta(microseconds=stamp_ns // 1000)


def status_event(goal: Goal, stamp_ns: int) -> Event:
    """The goal's state changed."""
    goal.last_event_id = event_id(stamp_ns, STATUS, goal.goal_id)
    ends_goal = goal.status in (GoalStatus.REJECTED, GoalStatus.LOST)
    return _goal_event("status", goal, stamp_ns, goal.summary(), ends_goal=ends_goal)


def feedback_event(goal: Goal, stamp_ns: int) -> Event:
    """The goal's feedback, as it stands in the goal."""
    goal.last_event_id = event_id(stamp_ns, FEEDBACK, goal.goal_id)
    return _goal_event("feedback", goal, stamp_ns, {"feedback": fragment(goal.feedback)}, droppable=True)


def result_event(goal: Goal, stamp_ns: int) -> Event:
    """The goal ended; the result is null where the action server did not give one."""
    goal.last_event_id = event_id(stamp_ns, RESULT, goal.goal_id)
    payload = {"status": goal.status.value, "result": fragment(goal.result), "error": goal.error}
    return _goal_event("result", goal, stamp_ns, payload, ends_goal=True)


def _goal_event(
    kind: str,
    goal: Goal,
    stamp_ns: int,
    payload: dict[str, Any],
    *,
    droppable: bool = False,
    ends_goal: bool = False,
) -> Event:
    head = {
        "type": kind,
        "id": goal.last_event_id,
        "time": moment(stamp_ns),
        "goal_id": goal.goal_id,
        "action_name": goal.action_name,
    }
    return Event(
        encode(head | payload),
        "goals",
        goal.goal_id,
        goal.action_name,
        droppable,
        id=goal.last_event_id,
        ends_goal=ends_goal,
    )


def message_event(kind: str, message: Json, stamp_ns: int, *, robot: str = "/") -> Event:
    """A message of a robot's topic, `battery` or `cmd_vel`."""
    identity = event_id(stamp_ns, kind)
    document = {"type": kind, "id": identity, "time": moment(stamp_ns), "robot": robot, kind: fragment(message)}
    return Event(encode(document), kind, droppable=True, id=identity, robot=robot)


def scene_event(scene: dict[str, Any], now: datetime, *, robot: str) -> Event:
    """Where a robot and its dock are. Only the newest is of interest, and none is kept."""
    document = {"type": "scene", "time": now, "robot": robot, "scene": scene}
    return Event(encode(document), "scene", droppable=True, robot=robot, supersedes=True)


def system_event(
    kind: str, payload: object, now: datetime, *, robot: str | None = None, action_name: str | None = None
) -> Event:
    """A change around goals: `battery_publisher`, `stop` or `simulator` of a robot, `action_server` of an action."""
    document = {"type": kind, "time": now, kind: payload} | ({} if robot is None else {"robot": robot})
    return Event(encode(document), "system", robot=robot, action_name=action_name)


def fleet_event(kind: str, now: datetime, **payload: Any) -> Event:
    """A change of the fleet: `robots`, those of them that changed; `alerts`, all of them."""
    return Event(encode({"type": kind, "time": now, **payload}), "robots")


def notice(kind: str, now: datetime, **payload: Any) -> Event:
    """A message of a stream about itself: `snapshot`, `resumed`, `gap`, `heartbeat`, `dropped`, `closing`."""
    return Event(encode({"type": kind, "time": now, **payload}), "notice")
