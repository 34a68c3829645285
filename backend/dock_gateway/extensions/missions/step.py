"""A step of a mission, as clients send it: what the robot does, and what happens if that fails."""

from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

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
from dock_gateway.http.schema import Schema

# Seconds that a service has for its answer, if its step does not say.
ANSWER_WITHIN = 5.0
KINDS = ("dock", "undock", "action", "navigate", "call", "publish", "notify", "wait")


class FailurePolicy(StrEnum):
    """What a mission does when a step has failed: it ends, or goes on with the next step."""

    END = "end"
    NEXT = "next"


class StepFields(Schema):
    """A step. One of the fields before `timeout_s` says what it is; the others are null.

    Attributes:
        timeout_s: Seconds after which it fails, or null: no limit, or 5 for a call. A goal that runs is canceled.
        tries: How often it is tried before it has failed.
        on_failure: What the mission does then.
    """

    dock: Request | None = None
    undock: Request | None = None
    action: ActionStep | None = None
    navigate: NavigateStep | None = None
    call: CallStep | None = None
    publish: PublishStep | None = None
    notify: NotifyStep | None = None
    wait: WaitStep | None = None
    timeout_s: Annotated[float, Field(ge=1, le=LONGEST)] | None = None
    tries: Annotated[int, Field(ge=1, le=20)] = 1
    on_failure: FailurePolicy = FailurePolicy.END

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        require_one(self, *KINDS)
        return self

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
    def request(self) -> dict[str, Any] | None:
        """The goal, as it was sent; None: that of the action by default."""
        if self.action is not None:
            return self.action.goal
        if self.navigate is not None:
            return self.navigate.goal()
        return self.dock or self.undock or None

    @property
    def waits_for_person(self) -> bool:
        """Whether it ends when a person continues the mission."""
        return self.wait is not None and self.wait.person

    @property
    def asked(self) -> dict[str, Any]:
        """The fields that clients send."""
        return {name: getattr(self, name) for name in StepFields.model_fields}
