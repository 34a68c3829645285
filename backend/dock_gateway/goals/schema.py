"""Schemas of requests and responses, for the OpenAPI document and the types generated from it.

Nothing is validated or encoded with them at run time: the ROS definitions decide what messages contain.
"""

import re
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, JsonValue

from dock_gateway.core.goal import GoalStatus, Origin, Verb
from dock_gateway.http.bodies import Name60, TagName, Unique, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import RosName, Schema
from dock_gateway.robots.schema import BatteryState, Scene


class DockGoal(Schema):
    """Goal of ConnectToChargingDock and DisconnectFromChargingDock."""

    desired_battery_state: BatteryState


class DockFeedback(Schema):
    """Feedback of ConnectToChargingDock and DisconnectFromChargingDock."""

    current_battery_state: BatteryState


class DockResult(Schema):
    """Result of ConnectToChargingDock and DisconnectFromChargingDock."""

    final_battery_state: BatteryState


# Other types of docking actions have messages of their own.
DockGoalMessage = DockGoal | dict[str, Any]
DockFeedbackMessage = DockFeedback | dict[str, Any]
DockResultMessage = DockResult | dict[str, Any]


class GoalError(Schema):
    """Why a goal did not succeed."""

    code: str
    detail: str


class GoalState(Schema):
    """The state of any goal, without its messages."""

    goal_id: str
    action_name: RosName
    action_type: str
    verb: Verb | None
    status: GoalStatus
    stalled: bool
    origin: Origin
    stage: str | None
    retries: int | None
    error: GoalError | None
    created_at: datetime
    updated_at: datetime
    finished_at: datetime | None
    feedback_count: int
    last_event_id: str | None


class GoalSummary(GoalState):
    """A goal of docking or undocking without its feedback and result."""

    goal: DockGoalMessage | None


class LiveGoal(GoalState):
    """A goal on any action, as streams send it; goal, feedback and result hold the fields of the action's messages."""

    goal: dict[str, Any] | None
    feedback: dict[str, Any] | None
    result: dict[str, Any] | None


class Note(Schema):
    """A note on a goal."""

    id: str
    by: str
    created_at: datetime
    text: str


class Goal(LiveGoal):
    """A goal on any action, with its tags in alphabetical order, and its notes, oldest first.

    These and what extensions know of it are null in answers to `POST`, which do not look them up. Tags and notes are
    null, too, while the history does not answer.
    """

    tags: list[str] | None
    notes: list[Note] | None


class GoalPage(Schema):
    """Goals on any action, newest first."""

    goals: list[Goal]
    next_cursor: str | None


class ActionStatusEvent(GoalState):
    """The state of a goal on any action changed."""

    type: Literal["status"]
    id: str
    time: datetime
    goal: dict[str, Any] | None


class ActionFeedbackEvent(Schema):
    """Feedback of a goal on any action."""

    type: Literal["feedback"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    feedback: dict[str, Any]


class ActionResultEvent(Schema):
    """A goal on any action ended."""

    type: Literal["result"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    status: GoalStatus
    result: dict[str, Any] | None
    error: GoalError | None


class PoseEvent(Schema):
    """Where the robot and its dock were while the goal ran; stored, not sent on streams. Sensors' data are null."""

    type: Literal["pose"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    scene: Scene


ACTION_EVENTS = (ActionStatusEvent, ActionFeedbackEvent, ActionResultEvent)


StoredEvent = ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent | PoseEvent


class GoalHistory(Schema):
    """The events of a goal, oldest first.

    `next_after` is null on the last page. `complete` is false if events that the gateway has received are not stored
    any more; what it has missed, because it was killed or cut off, it does not know.
    """

    events: list[StoredEvent]
    next_after: str | None
    complete: bool


# Lines of text: no control characters but line feeds and tabs; not blank.
_CONTROL = r"\x00-\x08\x0b-\x1f\x7f-\x9f"
TEXT = re.compile(rf"[^{_CONTROL}]*[^\s{_CONTROL}][^{_CONTROL}]*")
MAX_TEXT = 2000
NOTE_EXAMPLE: JsonValue = {"by": "Ada", "text": "A box stood in front of the left wheel."}


def _check_text(value: str) -> str:
    """Return the text of a note with lines that end in a line feed, without surrounding space."""
    text = value.replace("\r\n", "\n")
    if len(text) > MAX_TEXT or not TEXT.fullmatch(text):
        detail = f"got {len(text)} characters" if len(text) > MAX_TEXT else None
        raise expected(f"1 to {MAX_TEXT} characters, without control characters", detail)
    return text.strip()


class NoteBody(Schema):
    """A note to be added to a goal. `by` is who writes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [NOTE_EXAMPLE]})

    by: Name60
    text: Annotated[
        str,
        AfterValidator(_check_text),
        Field(json_schema_extra={"maxLength": MAX_TEXT, "pattern": f"^{TEXT.pattern}$"}),
    ]


class TagsBody(Schema):
    """The tags of a goal."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"tags": ["blocked", "maintenance"]}]})

    tags: Annotated[tuple[TagName, ...], Field(max_length=10), Unique]


class Tags(Schema):
    """The tags of all goals, in alphabetical order."""

    tags: list[str]


class GoalTags(Versioned):
    """The tags of a goal, in alphabetical order."""

    tags: list[str]


class ExportedGoal(Goal):
    """A goal with its events, oldest first; `complete` is that of its history."""

    complete: bool
    events: list[StoredEvent]
