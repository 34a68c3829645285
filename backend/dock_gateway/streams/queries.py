"""Query parameters of streams, which are the fields of `subscribe`, too: `?include= ?after= …`."""

from collections.abc import Mapping
from typing import Annotated

from fastapi import Depends, Header, Query
from pydantic import WithJsonSchema
from pydantic.json_schema import SkipJsonSchema

from dock_gateway.core.errors import FieldError, InvalidField, Place, got, not_covered
from dock_gateway.core.filters import EventFilter, WithoutFeedback
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.http.queries import EVENT_ID
from dock_gateway.http.requests import read_goal_id
from dock_gateway.robots.robots import Robots
from dock_gateway.setting_types import LONGEST_NAME, TOPIC
from dock_gateway.settings import Settings
from dock_gateway.streams.includes import Includes

STREAM_QUERY = ("goal_id", "action", "robot", "include", "feedback")
MIN_RATE, MAX_RATE = 0.01, 1000.0
# Only describes the parameters: they are read as those of WebSockets are, with the same errors.
FlagText = Annotated[str, WithJsonSchema({"type": "boolean"})]
RateText = Annotated[str, WithJsonSchema({"type": "number", "minimum": MIN_RATE, "maximum": MAX_RATE})]


async def _read_stream_query(
    *,
    feedback: Annotated[FlagText | None, Query(description="`false`: without feedback")] = None,
    after: Annotated[
        str | None,
        Query(description="Id of the event to resume after", json_schema_extra={"pattern": f"^{EVENT_ID.pattern}$"}),
    ] = None,
    max_rate: Annotated[RateText | None, Query(description="Feedback messages per second, at most")] = None,
) -> dict[str, str]:
    query = {"feedback": feedback, "after": after, "max_rate": max_rate}
    return {name: value for name, value in query.items() if value is not None}


# The query of a stream of one goal, as it was sent.
StreamQuery = Annotated[Mapping[str, str], Depends(_read_stream_query)]


def read_after(query: Mapping[str, str]) -> str | None:
    """Return the id of the event to resume after.

    Raises:
        InvalidField: It is not the id of an event.
    """
    return _read_event_id(query.get("after"), "after", "query")


async def _read_last_event_id(
    last_event_id: Annotated[
        str | SkipJsonSchema[None],
        Header(
            alias="Last-Event-ID",
            description="Id of the event to resume after, as `after`, which it takes precedence over",
            json_schema_extra={"pattern": f"^{EVENT_ID.pattern}$"},
        ),
    ] = None,
) -> str | None:
    return _read_event_id(last_event_id, "Last-Event-ID", "header")


# The header of who resumes a stream of one goal.
LastEventId = Annotated[str | None, Depends(_read_last_event_id)]


def _read_event_id(text: str | None, name: str, where: Place) -> str | None:
    if text is not None and not EVENT_ID.fullmatch(text):
        raise InvalidField([FieldError(name, "the id of an event", f"got {text[:60]!r}", where)])
    return text


def read_max_rate(query: Mapping[str, str], lowest: float = MIN_RATE, highest: float = MAX_RATE) -> float | None:
    """Return the reader's maximum rate, in messages per second.

    Raises:
        InvalidField: The value is not a number in range.
    """
    text = query.get("max_rate")
    if text is None:
        return None
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not lowest <= rate <= highest:
        expected = f"a number from {lowest:g} to {highest:g}"
        raise InvalidField([FieldError("max_rate", expected, f"got {text[:60]!r}", "query")])
    return rate


def read_feedback(query: Mapping[str, str]) -> bool:
    """Whether feedback is wanted.

    Raises:
        InvalidField: It is neither true nor false.
    """
    return read_flag(query, "feedback", default=True)


def read_flag(query: Mapping[str, str], name: str, *, default: bool) -> bool:
    """Return whether a parameter is true.

    Raises:
        InvalidField: It is neither true nor false.
    """
    text = query.get(name, str(default)).lower()
    if text not in ("true", "false"):
        raise InvalidField([FieldError(name, "true or false", f"got {text[:60]!r}", "query")])
    return text == "true"


async def read_event_filter(parts: Parts, query: Mapping[str, str], grant: Grant) -> EventFilter:
    """Return the event filter of a query, for a reader with this grant.

    Without `robot`, goals are those of all robots that the grant covers; battery, velocity and scene are those of the
    configured robot, or of the first one that the grant covers.

    Raises:
        InvalidField: A value is invalid.
        NotFound: There is no such goal or robot, or the grant does not cover the goal.
        NotAllowed: The grant does not cover the robot (`not_allowed`).
        ServedElsewhere: Another gateway serves the robot.
    """
    robot, action, goal_id = query.get("robot"), query.get("action"), query.get("goal_id")
    namespace = "/" if robot is None else read_namespace(robot)
    if action is not None and (len(action) > LONGEST_NAME or not TOPIC.fullmatch(action)):
        raise InvalidField([FieldError("action", "the name of an action", got(action), "query")])
    topics = parts[Includes].read(query.get("include", ""))
    kind = EventFilter if read_feedback(query) else WithoutFeedback
    goal = None if goal_id is None else await parts[Goals].get(read_goal_id(goal_id), grant)
    return kind(
        topics=topics | {"goals"},
        goal_id=None if goal is None else goal.goal_id,
        action_name=None if action is None else parts[Settings].resolve(action, None if robot is None else namespace),
        namespace=namespace,
        robot=_read_robot(parts[Robots], robot, grant),
        grant=grant if grant.limited or grant.topics or grant.share else None,
        homed=parts[RobotActions].homed_in(robot),
    )


def _read_robot(robots: Robots, robot: str | None, grant: Grant) -> str:
    # Whether there is such a robot or not.
    if robot is not None and not grant.own.covers_robot(name := read_namespace(robot)):
        raise not_covered(f"the robot {name}")
    found = robots.find(robot)
    if grant.covers_robot(found) or (grant.share is not None and not robots.namespaces()):
        return found
    if robot is None and not robots.own_robot:
        return found
    covered = [each for each in robots.namespaces() if grant.covers_robot(each)]
    if not covered:
        raise not_covered(f"the robot {found}")
    return min(covered)
