"""A gateway's answers and events. Fields, states and types that a newer gateway adds are no error."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Any, Self

from dock_gateway.core.goal import GoalError, GoalStatus, Origin, Verb

STATUSES = {str(status): status for status in GoalStatus}

# What the goals of a stream lack.
NOT_LOOKED_UP = dict.fromkeys(("tags", "notes", "recording"))
# A JSON object, as in the OpenAPI document of the gateway.
Document = dict[str, Any]


class _Read:
    @classmethod
    def read(cls, document: Mapping[str, Any]) -> Self:
        """Read the fields from a JSON object."""
        return cls(**{field.name: document[field.name] for field in fields(cls)})  # type: ignore[arg-type]


@dataclass(frozen=True)
class Goal(_Read):
    """A goal on any action, as docs/api.md describes it. `goal`, `feedback` and `result` are ROS messages as JSON.

    A state or a verb that only a newer gateway has is the text that it sent. `tags`, `notes` and `recording` are None
    in the answer to a goal that was sent or canceled: ask for it again. The last is None, too, without its extension.
    """

    goal_id: str
    action_name: str
    action_type: str
    verb: Verb | str | None
    status: GoalStatus | str
    stalled: bool
    origin: Origin | str
    goal: Document | None
    feedback: Document | None
    result: Document | None
    stage: str | None
    retries: int | None
    error: GoalError | None
    created_at: datetime
    updated_at: datetime
    finished_at: datetime | None
    feedback_count: int
    last_event_id: str | None
    tags: list[str] | None
    notes: list[Document] | None
    recording: Document | None

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> Self:
        """Read a goal from JSON."""
        times = {name: document[name] for name in ("created_at", "updated_at", "finished_at")}
        error = document["error"]
        return super().read(
            {
                **NOT_LOOKED_UP,
                **document,
                **{name: time and datetime.fromisoformat(time) for name, time in times.items()},
                "status": STATUSES.get(document["status"], document["status"]),
                "error": error and GoalError(error["code"], error["detail"]),
            }
        )

    @property
    def ended(self) -> bool:
        """Whether it has ended, in whatever state. A goal leaves `lost` when the action server returns and knows it."""
        return self.finished_at is not None


@dataclass(frozen=True)
class Event:
    """An event of a stream. `document` has all its fields, as docs/streams.md describes them for each `type`.

    `id` is None for events that are not replayed, `goal_id` for those that are about no goal.
    """

    type: str
    time: datetime
    id: str | None
    goal_id: str | None
    document: Document

    @classmethod
    def read(cls, document: Document) -> Self:
        """Read an event from JSON."""
        time = datetime.fromisoformat(document["time"])
        return cls(document["type"], time, document.get("id"), document.get("goal_id"), document)

    @property
    def ends_goal(self) -> bool:
        """Whether it is the last event of a stream of one goal."""
        if self.type == "snapshot":
            return all(goal["finished_at"] for goal in self.document["goals"])
        return self.type == "result" or (self.type == "status" and self.document["status"] == "lost")


@dataclass(frozen=True)
class Robot(_Read):
    """A robot. `name` is its namespace; `dock` and `undock` are its action servers, None if it has none.

    `docked` and `charging` are None if unknown.
    """

    name: str
    display_name: str | None
    groups: list[str]
    docked: bool | None
    charging: bool | None
    simulated: bool
    battery: Document
    stop: Document
    dock: Document | None
    undock: Document | None
    goals: list[Document]
    last_goal: Document | None


@dataclass(frozen=True)
class Battery(_Read):
    """The battery of a robot. `state` is a BatteryState, None before the first; `age_s` is its age in seconds.

    `percentage` is 0 to 1, and low below `low_below`. `implausible` are values that are not used, and what they should
    be. `Robot` and events have the same as a document, without `age_s` and `other_topics`.
    """

    state: Document | None
    percentage: float | None
    implausible: list[Document]
    received_at: datetime | None
    stale: bool
    stale_after_s: float
    low_below: float
    age_s: float | None
    other_topics: list[str]


@dataclass(frozen=True)
class StopReport(_Read):
    """The outcome of a stop: robots that it has stopped and others, goals that it cancels, and failures."""

    stopped: list[str]
    not_stopped: list[str]
    canceling: list[str]
    failed: list[Document]
    unconfirmed: list[str]
    stop: Document
    warning: Document | None
