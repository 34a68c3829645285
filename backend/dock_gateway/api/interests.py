"""What a stream is about, out of its query: `?goal_id= ?action= ?robot= ?include= ?feedback= ?after= ?max_rate=`."""

import re
from collections.abc import Mapping

from dock_gateway.api.answers import read_goal_id
from dock_gateway.errors import FieldError, InvalidField
from dock_gateway.gateway import Gateway
from dock_gateway.interest import Interest, WithoutFeedback
from dock_gateway.robots import read_namespace

QUERY = ("goal_id", "action", "robot", "include", "feedback")
INCLUDES = ("battery", "cmd_vel", "system", "scene", "robots")
EVENT_ID = re.compile(r"[0-9]{20}-[A-Za-z0-9_/-]{1,300}")
MIN_RATE, MAX_RATE = 0.01, 1000.0


def read_after(query: Mapping[str, str]) -> str | None:
    """The event to resume after.

    Raises:
        InvalidField: It is not the id of an event.
    """
    after = query.get("after")
    if after is not None and not EVENT_ID.fullmatch(after):
        raise InvalidField([FieldError("query.after", "the id of an event", f"got {after[:60]!r}")])
    return after


def read_max_rate(query: Mapping[str, str], lowest: float = MIN_RATE, highest: float = MAX_RATE) -> float | None:
    """Messages a second that the reader wants at most.

    Raises:
        InvalidField: It is not a number in range.
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
        raise InvalidField([FieldError("query.max_rate", expected, f"got {text[:60]!r}")])
    return rate


def read_feedback(query: Mapping[str, str]) -> bool:
    """Whether feedback is wanted.

    Raises:
        InvalidField: It is neither true nor false.
    """
    text = query.get("feedback", "true").lower()
    if text not in ("true", "false"):
        raise InvalidField([FieldError("query.feedback", "true or false", f"got {text[:60]!r}")])
    return text == "true"


async def read_interest(gateway: Gateway, query: Mapping[str, str]) -> Interest:
    """The interest that a query describes.

    Without `robot`, goals are those of every robot, battery, velocity and scene those of the configured one.

    Raises:
        InvalidField: A value is wrong.
        NotFound: There is no such goal or robot.
    """
    robot, action, goal_id = query.get("robot"), query.get("action"), query.get("goal_id")
    namespace = "/" if robot is None else read_namespace(robot)
    names = [name.strip() for name in query.get("include", "").split(",") if name.strip()]
    if unknown := [name for name in names if name not in INCLUDES]:
        raise InvalidField([FieldError("query.include", f"any of {', '.join(INCLUDES)}", f"got {unknown[0][:60]!r}")])
    kind = Interest if read_feedback(query) else WithoutFeedback
    return kind(
        topics=frozenset({"goals", *names}),
        goal_id=None if goal_id is None else (await gateway.goal(read_goal_id(goal_id))).goal_id,
        action_name=None if action is None else gateway.settings.resolve(action, None if robot is None else namespace),
        namespace=namespace,
        robot=gateway.robots.get(robot).namespace,
    )
