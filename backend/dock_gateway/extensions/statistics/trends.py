"""Compares how long docking takes each robot in the last seven days and in the seven before."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.core.filters import GoalFilter
from dock_gateway.extensions.statistics.tally import Span, Tallies, Tally, merged
from dock_gateway.goals.robot_actions import RobotActions

DAY = timedelta(days=1)
WEEK = 7  # days
# A median of fewer goals says little: one slow docking would move it.
MIN_GOALS = 8
# A smaller change is not worth a word.
MIN_CHANGE = 0.1


def two_weeks(until: datetime) -> list[Span]:
    """Return the last fourteen days of 24 hours, oldest first."""
    return [(until - (ago + 1) * DAY, until - ago * DAY) for ago in reversed(range(2 * WEEK))]


def change_of(now: Tally, before: Tally) -> float | None:
    """Return by which share the median duration has changed: 0.4 if docking takes 40 % longer.

    None if there is not enough to tell: each week needs `MIN_GOALS` succeeded goals, the change has to be `MIN_CHANGE`,
    and each median has to be outside of the middle half of the other week's durations.
    """
    if min(_succeeded(now), _succeeded(before)) < MIN_GOALS:
        return None
    (low, median, high), (earlier_low, earlier, earlier_high) = _quartiles(now), _quartiles(before)
    apart = not (earlier_low <= median <= earlier_high or low <= earlier <= high)
    change = median / earlier - 1 if earlier > 0 else 0.0
    return change if apart and abs(change) >= MIN_CHANGE else None


def _quartiles(tally: Tally) -> list[float]:
    return [value for value in tally.percentiles(25, 50, 75) if value is not None]


def _succeeded(tally: Tally) -> int:
    return sum(piece.size for piece in tally.durations)


@dataclass(frozen=True)
class DockingTrend:
    """The docking goals of a robot.

    Attributes:
        robot: Its namespace.
        wanted: The filter that selects them.
        days: A tally for each of the fourteen days, oldest first.
    """

    robot: str
    wanted: GoalFilter
    days: Sequence[Tally]

    def describe(self, spans: Sequence[Span], path: Callable[[GoalFilter], str]) -> dict[str, Any]:
        """Return the JSON of the trend; `path` returns where the goals of a filter are listed."""
        weeks = {"before": slice(0, WEEK), "now": slice(WEEK, 2 * WEEK)}
        tallies = {name: merged(self.days[part]) for name, part in weeks.items()}
        change = change_of(tallies["now"], tallies["before"])
        return {
            "robot": self.robot,
            **{
                name: {
                    "succeeded": _succeeded(tallies[name]),
                    "median_s": _rounded(tallies[name]),
                    "goals_path": path(replace(self.wanted, since=spans[part][0][0], until=spans[part][-1][1])),
                }
                for name, part in weeks.items()
            },
            "change": None if change is None else round(change, 4),
            "days": [_rounded(tally) for tally in self.days],
        }


def _rounded(tally: Tally) -> float | None:
    (median,) = tally.percentiles(50)
    return None if median is None else round(median, 3)


def find_trends(
    wanted: GoalFilter,
    found: Sequence[Tallies],
    robot_actions: RobotActions,
) -> list[DockingTrend]:
    """Return the trend of each robot that has docked in the fourteen days, sorted by name.

    Args:
        wanted: Which goals were asked for.
        found: The tallies of each day by action.
        robot_actions: The robots of the actions.
    """
    by_robot: dict[str, set[str]] = {}
    for name, robot in robot_actions.robots_of(name for tallies in found for name in tallies).items():
        if name in robot_actions.docking_names(robot, "dock"):
            by_robot.setdefault(robot, set()).add(name)
    trends = (
        DockingTrend(
            robot,
            replace(wanted, namespace="/", action_names=frozenset(names)),
            [merged(tally for name, tally in tallies.items() if name in names) for tallies in found],
        )
        for robot, names in sorted(by_robot.items())
    )
    return [trend for trend in trends if any(map(_succeeded, trend.days))]
