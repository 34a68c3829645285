"""The JSON shapes of the statistics."""

from datetime import datetime
from typing import Literal

from pydantic import ConfigDict, JsonValue

from dock_gateway.http.schema import Schema


class EndedStatuses(Schema):
    """The number of goals that ended in each state."""

    succeeded: int
    canceled: int
    aborted: int
    rejected: int
    lost: int


class GoalDurations(Schema):
    """How long the succeeded goals took, from creation to end, in seconds; null if none succeeded."""

    p10: float | None
    median: float | None
    p90: float | None


class ErrorCount(Schema):
    """The number of goals with an error code."""

    code: str
    count: int


class GoalCounts(Schema):
    """How the goals of a group ended.

    `success_rate` is the share of succeeded goals among those that were not canceled, `mean_retries` the mean of the
    retries that servers reported; null if there are no such goals. `errors` are the most frequent codes, `other_errors`
    is the number of goals with other codes. `goals_path` lists the goals, with those that have not ended.
    """

    ended: int
    statuses: EndedStatuses
    success_rate: float | None
    duration_s: GoalDurations
    mean_retries: float | None
    errors: list[ErrorCount]
    other_errors: int
    goals_path: str


class GoalGroup(GoalCounts):
    """How the goals of a day, a robot or an action ended; `key` is its name."""

    key: str


_COUNTS: dict[str, JsonValue] = {
    "ended": 42,
    "statuses": {"succeeded": 38, "canceled": 2, "aborted": 1, "rejected": 0, "lost": 1},
    "success_rate": 0.95,
    "duration_s": {"p10": 27.518, "median": 31.204, "p90": 44.871},
    "mean_retries": 0.1,
    "errors": [{"code": "action_server_lost", "count": 1}, {"code": "failed_to_charge", "count": 1}],
    "other_errors": 0,
}
_SPAN = "since=2026-11-21T00:00:00Z&until=2026-11-22T00:00:00Z"
_ACTION = "action=/robot1/connect_to_charging_dock"
EXAMPLE: JsonValue = {
    "since": "2026-11-21T00:00:00Z",
    "until": "2026-11-22T00:00:00Z",
    "by": "robot",
    "time_zone": "UTC",
    "total": {**_COUNTS, "goals_path": f"/goals?{_SPAN}"},
    "groups": [{"key": "/robot1", **_COUNTS, "goals_path": f"/goals?{_ACTION}&{_SPAN}"}],
}


class Statistics(Schema):
    """How the goals ended that were created from `since` up to but not including `until`.

    Days are in order of time, with those that have no goals; robots and actions are sorted by name.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    since: datetime
    until: datetime
    by: Literal["day", "robot", "action"]
    time_zone: str
    total: GoalCounts
    groups: list[GoalGroup]


class DockingTime(Schema):
    """The goals that docked a robot in seven days: how many, their median duration in seconds, and where they are."""

    succeeded: int
    median_s: float | None
    goals_path: str


class DockingTrend(Schema):
    """How long docking takes a robot.

    `change` is the change of the median as a share of what it was before: 0.4 if docking takes 40 % longer. It is null
    unless each of the two weeks has at least 8 succeeded goals, the change is 10 % or more, and each median is outside
    of the middle half of the other week's durations. `days` are the medians of the fourteen days, oldest first; null
    for a day without a succeeded goal.
    """

    robot: str
    now: DockingTime
    before: DockingTime
    change: float | None
    days: list[float | None]


_DOCKED: dict[str, JsonValue] = {"succeeded": 14, "median_s": 31.204, "goals_path": f"/goals?{_ACTION}&{_SPAN}"}


class DockingTimes(Schema):
    """The trends of the robots that have docked in the last fourteen days, sorted by name.

    `since` to `until` are the fourteen days; `now` are the last seven of them, `before` the seven before.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "since": "2026-11-08T00:00:00Z",
                    "until": "2026-11-22T00:00:00Z",
                    "robots": [
                        {
                            "robot": "/robot1",
                            "now": _DOCKED,
                            "before": {**_DOCKED, "succeeded": 18, "median_s": 22.288},
                            "change": 0.4,
                            "days": [
                                22.288,
                                None,
                                21.9,
                                22.4,
                                22.3,
                                None,
                                22.1,
                                30.8,
                                31.2,
                                None,
                                31.4,
                                30.9,
                                31.6,
                                31.2,
                            ],
                        }
                    ],
                }
            ]
        }
    )

    since: datetime
    until: datetime
    robots: list[DockingTrend]
