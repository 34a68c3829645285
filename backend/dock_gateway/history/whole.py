"""Whether the events of a goal are all there. Pure."""

from dock_gateway.events import nanoseconds, time_id
from dock_gateway.goals import Goal


def begin(goal: Goal, first: str) -> str:
    """What is older than this is no event of the goal; `first` is the id of its first event that is there.

    The robot's clock, which events have, and the gateway's may differ.
    """
    return min(first, time_id(nanoseconds(goal.created_at)))


def is_whole(goal: Goal, *, first: str | None, missing: str, feedback: int) -> bool:
    """Whether no event of a goal has been given up.

    Args:
        goal: The goal.
        first: Id of its first event that is there.
        missing: Id of the newest event of any goal that was given up.
        feedback: How many of its feedback events are there.
    """
    if first is None:
        return goal.last_event_id is None
    return missing < begin(goal, first) or feedback >= goal.feedback_count
