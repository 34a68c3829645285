"""A step of a mission, as clients send it: what the robot does, and what happens if that fails."""

from datetime import datetime, timedelta
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, Strict, WithJsonSchema, model_validator

from dock_gateway.core.goal import Verb
from dock_gateway.http.bodies import expected
from dock_gateway.http.queries import TIME_PATTERN, Time
from dock_gateway.http.schema import RosName, Schema
from dock_gateway.setting_types import LONGEST_NAME, TOPIC

# The longest that a step may take or wait, in seconds: a week.
LONGEST = 604_800.0


class FailurePolicy(StrEnum):
    """What a mission does when a step has failed: it ends, or goes on with the next step."""

    END = "end"
    NEXT = "next"


def _absolute(name: str) -> str:
    if len(name) > LONGEST_NAME or not name.startswith("/") or not TOPIC.fullmatch(name):
        raise expected("the absolute name of an action, such as /fibonacci")
    return name


ActionName = Annotated[
    RosName,
    AfterValidator(_absolute),
    WithJsonSchema({"type": "string", "maxLength": LONGEST_NAME, "pattern": f"^(?=/){TOPIC.pattern}$"}),
]
Request = Annotated[dict[str, Any], Field(description="As the body of `POST /dock` and `POST /undock`")]


class ActionStep(Schema):
    """A goal of any action. `goal` has the fields of the message; those left out have their defaults."""

    name: ActionName
    goal: Annotated[dict[str, Any], Field(default_factory=dict)]


class WaitStep(Schema):
    """One thing to wait for.

    `seconds`; a time, `until`; a charge of the battery (0 to 1), `battery`; or `person`: until a person continues the
    mission.
    """

    seconds: Annotated[float, Field(ge=0, le=LONGEST)] | None = None
    until: Annotated[Time, Strict(False), Field(json_schema_extra=TIME_PATTERN)] | None = None
    battery: Annotated[float, Field(gt=0, le=1)] | None = None
    person: bool = False

    def ends_at(self, started_at: datetime) -> datetime | None:
        """Return when it is over, if it began then; None if a charge or a person ends it."""
        return self.until if self.seconds is None else started_at + timedelta(seconds=self.seconds)

    @model_validator(mode="after")
    def _has_one_end(self) -> Self:
        ends = [name for name in ("seconds", "until", "battery") if getattr(self, name) is not None]
        ends += ["person"] if self.person else []
        if len(ends) != 1:
            raise expected("one of seconds, until, battery and person", f"got {' and '.join(ends) or 'none'}")
        return self


class StepFields(Schema):
    """A step. One of `dock`, `undock`, `action` and `wait` says what it is; the others are null.

    Attributes:
        timeout_s: Seconds after which it fails, or null: no limit. A goal that runs is canceled.
        tries: How often it is tried before it has failed.
        on_failure: What the mission does then.
    """

    dock: Request | None = None
    undock: Request | None = None
    action: ActionStep | None = None
    wait: WaitStep | None = None
    timeout_s: Annotated[float, Field(ge=1, le=LONGEST)] | None = None
    tries: Annotated[int, Field(ge=1, le=20)] = 1
    on_failure: FailurePolicy = FailurePolicy.END

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        kinds = [name for name in ("dock", "undock", "action", "wait") if getattr(self, name) is not None]
        if len(kinds) != 1:
            raise expected("one of dock, undock, action and wait", f"got {' and '.join(kinds) or 'none'}")
        return self

    @property
    def verb(self) -> Verb | None:
        """Whether it docks or undocks the robot."""
        return "dock" if self.dock is not None else "undock" if self.undock is not None else None

    @property
    def request(self) -> dict[str, Any] | None:
        """The goal, as it was sent; None: that of the action by default."""
        if self.action is not None:
            return self.action.goal
        return self.dock or self.undock or None

    @property
    def waits_for_person(self) -> bool:
        """Whether it ends when a person continues the mission."""
        return self.wait is not None and self.wait.person

    @property
    def asked(self) -> dict[str, Any]:
        """The fields that clients send."""
        return {name: getattr(self, name) for name in StepFields.model_fields}
