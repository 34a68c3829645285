"""Documents of a site as those of the hub: names get the site in front. Plain data in, plain data out.

What a site sends is read by explicit lists of fields: the hub shows nothing of a site that is not on them. A field that
an older site lacks is null; one that only a newer site knows is left out.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal, TypeVar
from uuid import UUID

import orjson

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.setting_types import LONGEST_NAME, NAME
from dock_gateway.sites.names import to_hub

Document = dict[str, Any]
Reader = Callable[[str, Any], Any]
T = TypeVar("T")

ROS_NAME = re.compile(f"/(?:{NAME.pattern}(?:/{NAME.pattern})*)?")
MAX_TEXT = 8000  # characters
# Bytes of a goal, its feedback or its result. A larger one is left out; the site has it.
MAX_MESSAGE = 128 * 1024
# Entries of a list, and bytes of a robot, an alert or an approval.
MAX_ENTRIES, MAX_DOCUMENT = 2000, 32 * 1024
ORIGINS = ("gateway", "automation", "external")
VERBS = ("dock", "undock", None)


class ForeignDocumentError(ValueError):
    """A site has sent what is not a document of a gateway. The sentence says what is wrong with it."""


@dataclass(frozen=True)
class Happening:
    """A change of a goal that a site has told of.

    Attributes:
        kind: Its state changed, or it ended with a result.
        goal: The goal as it was then, with names of the hub.
        at: When it happened, by the site's clock.
    """

    kind: Literal["status", "result"]
    goal: Goal
    at: datetime


# ---------------------------------------------------------------------- fields


def _as_is(_: str, value: Any) -> Any:
    return value


def _nothing(_: str, __: Any) -> None:
    return None


def _no(_: str, __: Any) -> bool:
    return False


def _name(site: str, value: Any) -> str:
    """Return a name of the hub: of a robot, an action or a topic."""
    if not isinstance(value, str) or len(value) > LONGEST_NAME or not ROS_NAME.fullmatch(value):
        raise ForeignDocumentError(f"{value!r:.60} is not a ROS name")
    return to_hub(site, value)


def _whole_site(site: str, value: Any) -> str:
    """Return the name of a robot; of the site, if it is not about one robot."""
    return to_hub(site, "/") if value is None else _name(site, value)


def _flag(_: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise ForeignDocumentError(f"{value!r:.60} is neither true nor false")
    return value


def _text(_: str, value: Any) -> str:
    if not isinstance(value, str) or len(value) > MAX_TEXT or "\0" in value:  # which databases do not accept
        raise ForeignDocumentError(f"{value!r:.60} is not a text")
    return value


def _site_id(site: str, value: Any) -> str:
    """Return the id of an alert or an approval: those of two sites may be the same."""
    return f"{site}.{_text(site, value)}"


def _one_of(*values: str) -> Reader:
    def read(_: str, value: Any) -> Any:
        if value not in values:
            raise ForeignDocumentError(f"{value!r:.60} is none of {', '.join(values)}")
        return value

    return read


def _shape(fields: Mapping[str, Reader], *, site_field: bool = False) -> Callable[[str, Any], Document]:
    def read(site: str, value: Any) -> Document:
        if not isinstance(value, dict):
            raise ForeignDocumentError(f"{value!r:.60} is not an object")
        document = {name: field(site, value.get(name)) for name, field in fields.items()}
        return _sized(document | {"site": site}) if site_field else document

    return read


def _sized(document: Document) -> Document:
    """Return a document, unless it is too large or too deep to be shown together with others."""
    try:
        size = len(orjson.dumps([[[[document]]]]))
    except orjson.JSONEncodeError as error:
        raise ForeignDocumentError(f"a document cannot be written as JSON: {error}") from None
    if size > MAX_DOCUMENT:
        raise ForeignDocumentError(f"a document has {size} bytes, and at most {MAX_DOCUMENT} are read")
    return document


def _maybe(reader: Reader) -> Reader:
    return lambda site, value: None if value is None else reader(site, value)


def _each(reader: Callable[[str, Any], T]) -> Callable[[str, Any], list[T]]:
    def read(site: str, value: Any) -> list[T]:
        if not isinstance(value, list):
            raise ForeignDocumentError(f"{value!r:.60} is not a list")
        if len(value) > MAX_ENTRIES:
            raise ForeignDocumentError(f"a list has {len(value)} entries, and at most {MAX_ENTRIES} are read")
        return [reader(site, item) for item in value]

    return read


def _copied(*names: str) -> dict[str, Reader]:
    return dict.fromkeys(names, _as_is)


_SERVER = _shape({"action_name": _name, **_copied("action_type", "available", "answering", "duplicate")})
_GOAL_STATE = _shape(
    {
        "goal_id": _text,
        "action_name": _name,
        "status": _one_of(*GoalStatus),
        "last_event_id": _nothing,  # an id of the site
        **_copied("action_type", "verb", "stalled", "origin", "stage", "retries", "error"),
        **_copied("created_at", "updated_at", "finished_at", "feedback_count"),
    }
)
_STOP = _shape({"latched": _flag, "robots": _each(_name), **_copied("since", "by", "persisted")})
_ROBOT = _shape(
    {
        "name": _name,
        "default": _no,  # a gateway is set up for one robot, the hub for none
        "battery_topic": _maybe(_name),
        "stop": _STOP,
        "dock": _maybe(_SERVER),
        "undock": _maybe(_SERVER),
        "join": _nothing,  # settings of the site
        "goals": _each(_GOAL_STATE),
        "last_goal": _maybe(_GOAL_STATE),
        "display_name": _maybe(_text),
        "groups": _each(_text),
        **_copied("docked", "charging", "simulated", "battery", "battery_publisher"),
    },
    site_field=True,
)
_ALERT = _shape(
    {
        "id": _site_id,
        "kind": _text,
        "robot": _whole_site,
        "severity": _one_of("critical", "warning"),
        **_copied("since", "title", "detail", "goal_id", "acknowledged"),
    },
    site_field=True,
)
_APPROVAL = _shape(
    {
        "approval_id": _site_id,
        "robot": _name,
        "action_name": _name,
        **_copied("agent", "client", "verb", "goal", "requested_at", "expires_at"),
    },
    site_field=True,
)


def read_robots(site: str, robots: Any) -> list[Document]:
    """Return robots of a site as those of the hub, without what only makes sense at the site.

    Raises:
        ForeignDocumentError: They are not robots.
    """
    return _each(_ROBOT)(site, robots)


def read_names(site: str, names: Any) -> list[str]:
    """Return the names of robots of a site as those of the hub.

    Raises:
        ForeignDocumentError: They are not names.
    """
    return _each(_name)(site, names)


def read_alerts(site: str, alerts: Any) -> list[Document]:
    """Return alerts of a site as those of the hub. One about no robot is about the site.

    Raises:
        ForeignDocumentError: They are not alerts.
    """
    return _each(_ALERT)(site, alerts)


def read_approvals(site: str, approvals: Any) -> list[Document]:
    """Return the goals of agents that wait at a site for a person as those of the hub.

    Raises:
        ForeignDocumentError: They are not approvals.
    """
    return _each(_APPROVAL)(site, approvals)


# ---------------------------------------------------------------------- goals


def read_goal(site: str, document: Any) -> Goal:
    """Return a goal of a site as one of the hub: of `GET /goals` or a snapshot, or of a `status` event.

    Raises:
        ForeignDocumentError: It is not a goal.
    """
    try:
        origin, verb = document["origin"], document["verb"]
        if origin not in ORIGINS or verb not in VERBS:
            raise ForeignDocumentError(f"a goal has the origin {origin!r:.40} and the verb {verb!r:.40}")
        goal = Goal(
            goal_id=read_goal_id(document["goal_id"]),
            action_name=_name(site, document["action_name"]),
            action_type=_text(site, document["action_type"]),
            created_at=read_time(document["created_at"]),
            origin=origin,
            verb=verb,
            status=GoalStatus(document["status"]),
            goal=_message(document["goal"]),
            feedback=_message(document.get("feedback")),
            result=_message(document.get("result")),
            error=read_error(document["error"]),
            stage=_maybe(_text)(site, document["stage"]),
            retries=_maybe(_count)(site, document["retries"]),
            stalled=_flag(site, document["stalled"]),
            finished_at=None if document["finished_at"] is None else read_time(document["finished_at"]),
            feedback_count=_count(site, document["feedback_count"]),
        )
        goal.updated_at = read_time(document["updated_at"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ForeignDocumentError):
            raise
        raise ForeignDocumentError(f"not a goal: {type(error).__name__}: {error}") from None
    return goal


def finish_goal(goal: Goal, event: Any) -> None:
    """Give a goal of the hub what the `result` event of a site says: how it ended.

    Raises:
        ForeignDocumentError: It is not such an event.
    """
    try:
        status = GoalStatus(event["status"])
        if not status.terminal:
            raise ForeignDocumentError(f"a result of a goal that is {status}")
        goal.result, goal.error = _message(event["result"]), read_error(event["error"])
        if goal.status is not status:
            goal.status, goal.stalled = status, False
            goal.updated_at = goal.finished_at = read_time(event["time"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ForeignDocumentError):
            raise
        raise ForeignDocumentError(f"not the end of a goal: {type(error).__name__}: {error}") from None


def ends_of(goal: Goal) -> list[Happening]:
    """Return the events of a goal's end, as they follow from the goal: those of the site may be gone."""
    if not goal.status.final:
        return []
    at = goal.finished_at or goal.updated_at
    ends = [Happening("status", goal, at)]
    return ends if goal.status is GoalStatus.REJECTED else [*ends, Happening("result", goal, at)]


def read_goal_id(value: Any) -> str:
    """Return the id of a goal.

    Raises:
        ForeignDocumentError: It is not a UUID.
    """
    try:
        return str(UUID(value))
    except (ValueError, TypeError, AttributeError):
        raise ForeignDocumentError(f"{value!r:.60} is not the id of a goal") from None


def read_time(value: Any) -> datetime:
    """Return a time.

    Raises:
        ForeignDocumentError: It is none, or has no time zone.
    """
    try:
        time = datetime.fromisoformat(value)
    except (ValueError, TypeError):
        time = None
    if time is None or time.tzinfo is None or not 1971 < time.year < 2200:
        raise ForeignDocumentError(f"{value!r:.60} is not a time")
    return time


def read_error(value: Any) -> GoalError | None:
    """Return why a goal did not succeed.

    Raises:
        ForeignDocumentError: It is not an error of a goal.
    """
    if value is None:
        return None
    if not isinstance(value, dict):
        raise ForeignDocumentError(f"{value!r:.60} is not the error of a goal")
    return GoalError(_text("", value.get("code")), _text("", value.get("detail")))


def _message(value: Any) -> bytes | None:
    if value is None:
        return None
    if not isinstance(value, dict):
        raise ForeignDocumentError(f"{value!r:.60} is not a message")
    message = orjson.dumps(value)
    return message if len(message) <= MAX_MESSAGE else None


def _count(_: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**31:
        raise ForeignDocumentError(f"{value!r:.60} is not a count")
    return value
