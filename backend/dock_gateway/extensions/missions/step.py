"""A step of a mission, as clients send it: what the robot does, and what happens if that fails."""

from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError, ValidatorFunctionWrapHandler, WrapValidator, model_validator

from dock_gateway.core.goal import Verb
from dock_gateway.extensions.missions.step_kinds import (
    LONGEST,
    ActionStep,
    CallStep,
    NavigateStep,
    NotifyStep,
    PublishStep,
    Request,
    WaitStep,
    require_one,
)
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.schema import Schema

# Seconds that a service has for its answer, if its step does not say.
ANSWER_WITHIN = 5.0
# Steps inside of one; `program` limits all of them together.
MAX_INSIDE = 200
KINDS = ("dock", "undock", "action", "navigate", "call", "publish", "notify", "wait")


class FailurePolicy(StrEnum):
    """What happens when a step has failed: the mission ends, or goes on with the next step."""

    END = "end"
    NEXT = "next"


class GoTo(Schema):
    """What happens when a step has failed: the mission goes on with a later step, by its name."""

    go_to: Name60


def _read_policy(value: object, read: ValidatorFunctionWrapHandler) -> object:
    try:
        return read(value)
    except ValidationError:
        wanted = 'end, next, or {"go_to": the name of a later step}'
        raise expected(wanted, f"got {str(value)[:60]!r}") from None


Policy = Annotated[FailurePolicy | GoTo, WrapValidator(_read_policy)]


class Repeat(Schema):
    """Steps that are repeated: `times` is null if that is for ever. `round` is the present one, from 1."""

    times: int | None
    round: int


class Alternatives(Schema):
    """How many steps there are of which the first that works is taken."""

    alternatives: int


class SingleStep(Schema):
    """What a step does itself, and what holds for each.

    Attributes:
        name: By which other steps go to it.
        timeout_s: Seconds after which it fails, or null: no limit, or 5 for a call. A goal that runs is canceled.
        tries: How often it is tried before it has failed.
        on_failure: What the mission does then. By default it ends, unless the step is inside of another one.
        interruptible: Whether its goal is canceled when the robot has to charge; it begins again afterwards.
    """

    dock: Request | None = None
    undock: Request | None = None
    action: ActionStep | None = None
    navigate: NavigateStep | None = None
    call: CallStep | None = None
    publish: PublishStep | None = None
    notify: NotifyStep | None = None
    wait: WaitStep | None = None
    name: Name60 | None = None
    timeout_s: Annotated[float, Field(ge=1, le=LONGEST)] | None = None
    tries: Annotated[int, Field(ge=1, le=20)] = 1
    on_failure: Policy = FailurePolicy.END
    interruptible: bool = False

    @property
    def verb(self) -> Verb | None:
        """Whether it docks or undocks the robot."""
        return "dock" if self.dock is not None else "undock" if self.undock is not None else None

    @property
    def sends_goal(self) -> bool:
        """Whether it is a goal of an action."""
        return self.verb is not None or self.action is not None or self.navigate is not None

    @property
    def is_message(self) -> bool:
        """Whether it is a call or a message: nobody can tell later whether it was carried out."""
        return self.call is not None or self.publish is not None

    @property
    def answer_within(self) -> float:
        """The seconds that its service has for the answer."""
        return self.timeout_s or ANSWER_WITHIN

    @property
    def place(self) -> str | None:
        """The id of the place that it drives to, if it names one."""
        return None if self.navigate is None else self.navigate.place

    @property
    def waits_for_person(self) -> bool:
        """Whether it ends when a person continues the mission."""
        return self.wait is not None and self.wait.person

    @property
    def takes_time(self) -> bool:
        """Whether it is a goal or a wait."""
        return self.sends_goal or self.wait is not None

    @property
    def common(self) -> dict[str, Any]:
        """The fields that every step has."""
        return {name: getattr(self, name) for name in SingleStep.model_fields}


Inside = Annotated[
    list[dict[str, Any]], Field(min_length=1, max_length=MAX_INSIDE, description="Steps, as those of a mission")
]


class RepeatStep(Schema):
    """Steps that are taken again and again: so many `times`, or for ever if that is null."""

    steps: Inside
    times: Annotated[int, Field(ge=1, le=1_000_000)] | None = None


class StepFields(SingleStep):
    """A step. One of its fields before `name`, or one of the last two, says what it is; the others are null.

    Attributes:
        repeat: Steps that are repeated.
        first_that_works: Steps of which each is taken only if those before it have failed.
    """

    repeat: RepeatStep | None = None
    first_that_works: Inside | None = None

    @property
    def inside(self) -> tuple[str, list[dict[str, Any]]]:
        """The steps inside of it, and where they are in it; none for one that does something itself."""
        if self.repeat is not None:
            return "repeat.steps", self.repeat.steps
        return ("", []) if self.first_that_works is None else ("first_that_works", self.first_that_works)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        require_one(self, *KINDS, "repeat", "first_that_works")
        if self.inside[1] and (self.timeout_s is not None or self.tries != 1):
            raise expected("timeout_s and tries in the steps inside of it, not here")
        if self.interruptible and (self.verb is not None or not self.sends_goal):
            raise expected("interruptible only where a goal is sent that neither docks nor undocks")
        return self
