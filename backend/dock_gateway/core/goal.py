"""A goal as the gateway knows it: plain data and the rules for how it changes. No ROS, no socket, no clock."""

from dataclasses import dataclass, field
from datetime import datetime, timedelta
from enum import StrEnum
from typing import Any, Literal

import orjson

# A ROS message that has been encoded to JSON, once. It is embedded as it is wherever it goes.
Json = bytes

Origin = Literal["gateway", "external"]


# A goal that has been lost for so long is not expected back.
LOST_FOR = timedelta(hours=1)


class GoalStatus(StrEnum):
    """ROS's states of a goal, and ours before and beyond ROS (`pending`, `rejected`, `lost`)."""

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
        """Whether the goal has ended. `lost` is left again when the action server returns and knows the goal."""
        return self in _TERMINAL

    @property
    def final(self) -> bool:
        """Whether nothing can follow any more."""
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
    """Why a goal did not succeed: a stable code and a sentence."""

    code: str
    detail: str


# The code of a goal that ended without its result.
NO_RESULT = "result_unavailable"

# The code of a goal whose gateway ended before the server's answer was stored, and which the server does not know.
UNCONFIRMED = "goal_unconfirmed"

# What a goal is rejected for by the gateway itself, before it is sent.
_UNSENT = frozenset({"action_server_unavailable", "ros_unavailable", "stopped"})


@dataclass(slots=True, eq=False)
class Goal:
    """One goal on one action, whoever sent it.

    `goal`, `feedback` and `result` are messages encoded to JSON, or None where they are not known (yet). `stage` is the
    last one that the server was in, in its own words, and `retries` how often it began anew, where it says so.
    """

    goal_id: str
    action_name: str
    action_type: str
    created_at: datetime
    origin: Origin = "gateway"
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
        """Whether it has ended without ever having been sent to the action server."""
        return self.status is GoalStatus.REJECTED and self.error is not None and self.error.code in _UNSENT

    @property
    def unconfirmed(self) -> bool:
        """Whether it may never have reached the action server: it can be sent once more, under the same id."""
        return self.status is GoalStatus.LOST and self.error is not None and self.error.code == UNCONFIRMED

    def advance(self, status: GoalStatus, now: datetime) -> bool:
        """Move on to `status`; False, and no change, where that would be a step back.

        Messages overtake one another on DDS: an `executing` that comes after `succeeded` is old news. Only `lost`
        may be left for a state that stands before it.
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
        """The action server is gone, or does not know the goal; whether that is news."""
        unconfirmed = self.status is GoalStatus.PENDING and error.code == "action_server_lost"
        if not self.advance(GoalStatus.LOST, now):
            return False
        self.error = GoalError(UNCONFIRMED, f"{error.detail}; it may never have got it") if unconfirmed else error
        return True

    def hear(self, feedback: Json, now: datetime) -> None:
        """Take up a feedback message."""
        self.feedback = feedback
        self.feedback_count += 1
        self.updated_at = now

    def progress(self, stage: str | None, retries: int | None, now: datetime) -> bool:
        """Take up how far the server is; False where that is known. None is no news."""
        stage, retries = stage or self.stage, self.retries if retries is None else retries
        if (stage, retries) == (self.stage, self.retries):
            return False
        self.stage, self.retries, self.updated_at = stage, retries, now
        return True

    def remember(self, known: "Goal") -> None:
        """Take over what another gateway, or this one before a restart, wrote down about the same goal."""
        self.attribute(known)
        self.feedback_count += known.feedback_count
        self.stage = self.stage or known.stage
        self.retries = known.retries if self.retries is None else self.retries

    def attribute(self, known: "Goal") -> None:
        """Take over who sent it, when, and what was asked for."""
        self.origin = known.origin
        self.created_at = known.created_at
        self.goal = self.goal or known.goal

    def summary(self) -> dict[str, Any]:
        """Every field but feedback and result, ready for `orjson`."""
        return {
            "goal_id": self.goal_id,
            "action_name": self.action_name,
            "action_type": self.action_type,
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
        """Every field but the messages, ready for `orjson`."""
        summary = self.summary()
        del summary["goal"]
        return summary

    def document(self) -> dict[str, Any]:
        """The whole goal, ready for `orjson`."""
        return {**self.summary(), "feedback": fragment(self.feedback), "result": fragment(self.result)}


def fragment(message: Json | None) -> orjson.Fragment | None:
    """A message that is JSON already, for embedding."""
    return None if message is None else orjson.Fragment(message)


def encode(document: Any) -> bytes:
    """JSON as the gateway writes it everywhere: times as RFC 3339 UTC, NaN as null."""
    text = orjson.dumps(document, option=orjson.OPT_UTC_Z | orjson.OPT_SERIALIZE_NUMPY)
    # A copy: what `dumps` returns keeps its whole buffer, 8 kB for an event of 500 bytes that is remembered for long.
    return bytes(memoryview(text))
