"""Merges two versions of a goal, in any order: two replicas write the same goals."""

from copy import copy

from dock_gateway.core.goal import NO_RESULT, Goal, GoalError, GoalStatus

RANK = {status: rank for rank, status in enumerate(GoalStatus)}


def merge(stored: Goal, news: Goal) -> Goal:
    """Return a new goal that combines both versions.

    - The status only moves forward, and a final one stays. Between `lost` and an earlier status the later version wins.
    - Origin `gateway` (the sender) overrides `external` (an observer), and its `created_at` is used.
    - Verb, goal, feedback, result and stage are never overwritten by None. Neither is the error, unless it was that of
      a `lost` goal that returned, or says that there is no result although there is one. A goal that succeeded does
      not take over the other version's error.
    """
    merged = copy(stored)
    status_from, other = (news, stored) if _supersedes(news, stored) else (stored, news)
    latest, earlier = (stored, news) if stored.updated_at > news.updated_at else (news, stored)
    merged.status = status_from.status
    merged.finished_at = status_from.finished_at
    merged.stalled = latest.stalled and not merged.status.terminal
    merged.result = status_from.result or other.result
    merged.error = _error(status_from, other, merged)
    merged.verb = stored.verb or news.verb
    merged.goal = stored.goal or news.goal
    merged.feedback = latest.feedback or earlier.feedback
    merged.stage = latest.stage or earlier.stage
    merged.retries = max((goal.retries for goal in (stored, news) if goal.retries is not None), default=None)
    merged.feedback_count = max(stored.feedback_count, news.feedback_count)
    merged.last_event_id = max(filter(None, (stored.last_event_id, news.last_event_id)), default=None)
    merged.updated_at = latest.updated_at
    if stored.origin == news.origin:
        merged.created_at = min(stored.created_at, news.created_at)
    elif news.origin != "external":
        merged.origin, merged.created_at = news.origin, news.created_at
    return merged


def _error(status_from: Goal, other: Goal, merged: Goal) -> GoalError | None:
    error = status_from.error
    returned = other.status is GoalStatus.LOST and merged.status is not GoalStatus.LOST
    if error is None and not returned and merged.status is not GoalStatus.SUCCEEDED:
        error = other.error
    return None if merged.result is not None and error is not None and error.code == NO_RESULT else error


def _supersedes(news: Goal, stored: Goal) -> bool:
    if stored.status.final or news.status.final:
        return not stored.status.final
    if GoalStatus.LOST in (stored.status, news.status):
        return news.updated_at >= stored.updated_at
    return RANK[news.status] >= RANK[stored.status]


def merge_all(stored: dict[str, Goal], waiting: dict[str, Goal]) -> dict[str, Goal]:
    """Merge the pending goals with their stored versions; always returns copies."""
    return {goal_id: merge(stored.get(goal_id, goal), goal) for goal_id, goal in waiting.items()}
