"""A step of a mission as it is stored: what clients have sent, and how far it has come. Plain data."""

from datetime import datetime, timedelta
from enum import StrEnum
from typing import Any

from dock_gateway.extensions.missions.step import Alternatives, Repeat, SingleStep
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.http.schema import Schema


class StepStatus(StrEnum):
    """The states of a step."""

    WAITING = "waiting"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    SKIPPED = "skipped"
    CANCELED = "canceled"


class Reason(Schema):
    """Why a step or a mission failed, or what its last try ended with."""

    code: str
    detail: str


class StepPlace(SingleStep):
    """A step of a program.

    Attributes:
        path: Where it is in the request, after `steps.`: `1.repeat.steps.0` is the first step of the second one.
        repeat: The rounds of the steps behind it that are inside of it.
        first_that_works: How many of the steps behind it are alternatives, with those inside of them.
    """

    path: str
    repeat: Repeat | None = None
    first_that_works: Alternatives | None = None


class StepEntry(StepPlace):
    """A step as it is stored.

    Attributes:
        size: How many of the steps behind it are inside of it.
        status: Its state.
        attempt: How often it was begun; the number of the present try.
        drives_to: Where the place that it drives to was when this try began.
        goal_id: The goal of this try, once it was accepted.
        started_at: When this try began.
        finished_at: When it ended for the last time.
        error: Why the last try failed. While it is running: why its goal is being canceled.
        tried: Tries that have failed since it was first begun or continued.
        retry_at: When the next try begins.
        sender: The gateway that sends the goal of this try; None: the only one that there is.
        sends_until: Until when it may; None: without limit.
    """

    path: str = ""
    size: int = 0
    status: StepStatus = StepStatus.WAITING
    attempt: int = 0
    drives_to: Waypoint | None = None
    goal_id: str | None = None
    started_at: datetime | None = None
    finished_at: datetime | None = None
    error: Reason | None = None
    tried: int = 0
    retry_at: datetime | None = None
    sender: str | None = None
    sends_until: datetime | None = None

    @property
    def asked(self) -> dict[str, Any]:
        """What clients have sent of it."""
        repeat = self.repeat and self.repeat.model_copy(update={"round": 0})
        return {name: getattr(self, name) for name in (*StepPlace.model_fields, "size")} | {"repeat": repeat}

    @property
    def request(self) -> dict[str, Any] | None:
        """The goal, as it was sent; None: that of the action by default.

        Raises:
            ValueError: It is that of a place, and it is not known where that is.
        """
        if self.action is not None:
            return self.action.goal
        if self.navigate is None:
            return self.dock or self.undock or None
        if self.place is not None and self.drives_to is None:
            raise ValueError(f"nobody knows where the place {self.place} is")
        return self.navigate.goal(self.drives_to)

    @property
    def has_goal(self) -> bool:
        """Whether its goal is to be sent, or was sent and may be running."""
        return self.status is StepStatus.RUNNING and self.sends_goal

    @property
    def has_message(self) -> bool:
        """Whether its call or message is to be sent, or may have been sent."""
        return self.status is StepStatus.RUNNING and self.is_message

    @property
    def fails_at(self) -> datetime | None:
        """When this try has taken too long; None: there is no limit."""
        if self.started_at is None or self.timeout_s is None:
            return None
        return self.started_at + timedelta(seconds=self.timeout_s)

    def is_late(self, now: datetime) -> bool:
        """Return whether this try has taken too long."""
        return self.fails_at is not None and now >= self.fails_at
