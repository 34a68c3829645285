"""A goal: plain data and the rules for its state changes. No ROS, no socket, no clock."""

from dataclasses import dataclass, field
from datetime import datetime, timedelta
from enum import StrEnum
from typing import Any, Literal

import orjson

# A ROS message encoded to JSON, once. It is embedded as it is in every document.
Json = bytes

# Who sent a goal: a client of a gateway, the gateway itself (a rule of automatic docking, a mission), a client of ROS.
Origin = Literal["gateway", "automation", "external"]

# What a goal on one of a robot's two docking actions does.
Verb = Literal["dock", "undock"]


# A goal that has been lost for longer than this is not expected back.
LOST_FOR = timedelta(hours=1)


class GoalStatus(StrEnum):
    """The states of a goal in ROS, and three of our own (`pending`, `rejected`, `lost`)."""

    PENDING = "pending"
    ACCEPTED = "accepted"
    EXECUTING = "executing"
    CANCELING = "canceling"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"
    REJECTED = "rejected"
    LOST = "lost"

    @property
    def terminal(self) -> bool:
        """Whether the goal has ended. A goal leaves `lost` when the action server returns and knows the goal."""
        return self in _TERMINAL

    @property
    def final(self) -> bool:
        """Whether no other state can follow."""
        return self in _TERMINAL and self is not GoalStatus.LOST


_TERMINAL = frozenset(
    {GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.LOST}
)
_RANK = {status: rank for rank, status in enumerate(GoalStatus)}

# action_msgs/GoalStatus
FROM_ROS = {
    1: GoalStatus.ACCEPTED,
    2: GoalStatus.EXECUTING,
    3: GoalStatus.CANCELING,
    4: GoalStatus.SUCCEEDED,
    5: GoalStatus.CANCELED,
    6: GoalStatus.ABORTED,
}


@dataclass(frozen=True)
class GoalError:
    """The reason why a goal did not succeed: a stable code and a human-readable sentence."""

    code: str
    detail: str


@dataclass(frozen=True)
class ResultAnswer:
    """The response to a result request; `status` is None if the server does not know the goal.

    `remark` names faults around the robot; it is added to the reason if the goal was aborted.
    """

    status: GoalStatus | None = None
    result: Json | None = None
    error: GoalError | None = None
    remark: str = ""


# The code of a goal that ended without its result.
NO_RESULT = "result_unavailable"

# The code of a goal that the server does not know and whose gateway ended before the server's answer was stored.
UNCONFIRMED = "goal_unconfirmed"

# Codes for which the gateway itself rejects a goal before it is sent.
_UNSENT = frozenset({"action_server_unavailable", "ros_unavailable", "stopped", "invalid_token"})


@dataclass(slots=True, eq=False)
class Goal:
    """One goal on one action, regardless of the sender.

    `verb` is None on any action but the two for docking.
    `goal`, `feedback` and `result` are messages encoded to JSON, or None while they are not known. `stage` is the last
    stage that the server reported, in its own words, and `retries` its number of retries, where it reports them.
    """

    goal_id: str
    action_name: str
    action_type: str
    created_at: datetime
    origin: Origin = "gateway"
    verb: Verb | None = None
    status: GoalStatus = GoalStatus.PENDING
    goal: Json | None = None
    feedback: Json | None = None
    result: Json | None = None
    error: GoalError | None = None
    stage: str | None = None
    retries: int | None = None
    stalled: bool = False
    updated_at: datetime = field(init=False)
    finished_at: datetime | None = None
    feedback_count: int = 0
    last_event_id: str | None = None

    def __post_init__(self) -> None:
        self.updated_at = self.created_at

    @property
    def unsent(self) -> bool:
        """Whether the goal ended without being sent to the action server."""
        return self.status is GoalStatus.REJECTED and self.error is not None and self.error.code in _UNSENT

    @property
    def unconfirmed(self) -> bool:
        """Whether the goal may never have reached the action server. It can be sent again under the same id."""
        return self.status is GoalStatus.LOST and self.error is not None and self.error.code == UNCONFIRMED

    def advance(self, status: GoalStatus, now: datetime) -> bool:
        """Move on to `status`. Return False, without a change, where that would be a step back.

        Messages overtake one another on DDS: an `executing` that comes after `succeeded` is outdated. Only from `lost`
        can a goal go back to an earlier state.
        """
        if self.status.final or status is self.status:
            return False
        if self.status is not GoalStatus.LOST and _RANK[status] < _RANK[self.status]:
            return False
        if self.status is GoalStatus.LOST:
            self.error = None
        self.status = status
        self.stalled = False
        self.updated_at = now
        self.finished_at = now if status.terminal else None
        return True

    def lose(self, error: GoalError, now: datetime) -> bool:
        """Mark the goal as lost: the action server is gone or does not know it. Return whether this is a change."""
        unconfirmed = self.status is GoalStatus.PENDING and error.code == "action_server_lost"
        if not self.advance(GoalStatus.LOST, now):
            return False
        self.error = (
            GoalError(UNCONFIRMED, f"{error.detail}; it may not have received the goal") if unconfirmed else error
        )
        return True

    def hear(self, feedback: Json, now: datetime) -> None:
        """Store a feedback message."""
        self.feedback = feedback
        self.feedback_count += 1
        self.updated_at = now

    def progress(self, stage: str | None, retries: int | None, now: datetime) -> bool:
        """Store the server's progress; return False if nothing changed. None means no new value."""
        stage, retries = stage or self.stage, self.retries if retries is None else retries
        if (stage, retries) == (self.stage, self.retries):
            return False
        self.stage, self.retries, self.updated_at = stage, retries, now
        return True

    def remember(self, known: "Goal") -> None:
        """Take over what another gateway, or this one before a restart, stored about the same goal."""
        self.attribute(known)
        self.feedback_count += known.feedback_count
        self.stage = self.stage or known.stage
        self.retries = known.retries if self.retries is None else self.retries

    def attribute(self, known: "Goal") -> None:
        """Take over the goal's origin, creation time and message."""
        self.origin = known.origin
        self.created_at = known.created_at
        self.goal = self.goal or known.goal

    def summary(self) -> dict[str, Any]:
        """Return every field but feedback and result, ready for `orjson`."""
        return {
            "goal_id": self.goal_id,
            "action_name": self.action_name,
            "action_type": self.action_type,
            "verb": self.verb,
            "status": self.status.value,
            "stalled": self.stalled,
            "origin": self.origin,
            "goal": fragment(self.goal),
            "stage": self.stage,
            "retries": self.retries,
            "error": self.error,
            "created_at": self.created_at,
            "updated_at": self.updated_at,
            "finished_at": self.finished_at,
            "feedback_count": self.feedback_count,
            "last_event_id": self.last_event_id,
        }

    def state(self) -> dict[str, Any]:
        """Return every field but the messages, ready for `orjson`."""
        summary = self.summary()
        del summary["goal"]
        return summary

    def document(self) -> dict[str, Any]:
        """Return the whole goal, ready for `orjson`."""
        return {**self.summary(), "feedback": fragment(self.feedback), "result": fragment(self.result)}


def fragment(message: Json | None) -> orjson.Fragment | None:
    """Wrap a message that is JSON already, for embedding."""
    return None if message is None else orjson.Fragment(message)


def encode(document: Any) -> bytes:
    """Encode to JSON, as everywhere in the gateway: times as RFC 3339 UTC, NaN as null."""
    text = orjson.dumps(document, option=orjson.OPT_UTC_Z | orjson.OPT_SERIALIZE_NUMPY)
    # Copy: the bytes that `dumps` returns keep the whole buffer alive, 8 kB for a long-lived event of 500 bytes.
    return bytes(memoryview(text))
