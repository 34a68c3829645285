"""Compares two courses of a goal."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from itertools import pairwise, zip_longest
from typing import NamedTuple

from docking.core.errors import ErrorCode
from docking.core.observation import STANDSTILL, Velocity
from docking.replay.course import Course

BRIEF = 1.0
"""Seconds: what is so short does not count. A threshold may be crossed at one control step or at another one."""
AROUND = 0.15
"""Seconds: a velocity is compared with those that were commanded so shortly before or after it."""
LINEAR, ANGULAR = 0.03, 0.1
"""In m/s and rad/s; velocities that differ by no more are the same."""
HELD = 0.5
"""Seconds that a commanded velocity holds."""

ENDED_FROM_OUTSIDE = frozenset(
    code.value for code in (ErrorCode.STOP_LATCHED, ErrorCode.PREEMPTED, ErrorCode.SHUTTING_DOWN, ErrorCode.NOT_ACTIVE)
)
"""Errors that no sensor causes: whoever caused them is not in the recording."""


class Difference(NamedTuple):
    """A difference between a replayed course and the recorded one: the seconds since the goal was accepted, and how."""

    at: float
    how: str

    def __str__(self) -> str:
        """Return it as a line of text."""
        return f"{self.at:6.1f} s  {self.how}"


def differences(recorded: Course, replayed: Course) -> list[Difference]:
    """Return where the replayed course differs from the recorded one; nothing where they are the same."""
    return [*_stages(recorded, replayed), *_velocities(recorded, replayed), *_ends(recorded, replayed)]


def _stages(recorded: Course, replayed: Course) -> Iterator[Difference]:
    for then, now in zip_longest(_lasting(recorded), _lasting(replayed)):
        if now is None:
            yield Difference(then[0], f"the stage {then[1]} does not come")
        elif then is None:
            yield Difference(now[0], f"the stage {now[1]} comes, which was not recorded")
        elif then[1] != now[1]:
            how = f"the stage {now[1]} comes ({now[0]:.1f} s) instead of {then[1]} ({then[0]:.1f} s)"
            yield Difference(min(then[0], now[0]), how)
            return  # those that follow are of another story
        elif abs(then[0] - now[0]) > BRIEF:
            yield Difference(then[0], f"the stage {then[1]} comes at {now[0]:.1f} s")


def _lasting(course: Course) -> list[tuple[float, str]]:
    """Return the stages without those that are over at once."""
    found = Course()
    for (at, stage), (until, _) in pairwise([*course.stages, (course.ended_at, "")]):
        if until - at >= BRIEF:
            found.enter(at, stage)
    return found.stages


def _ends(recorded: Course, replayed: Course) -> Iterator[Difference]:
    if not recorded.end or recorded.end == "CANCELED" or recorded.error_code in ENDED_FROM_OUTSIDE:
        if replayed.end:
            yield Difference(replayed.ended_at, f"it ends as {_end(replayed)}, before it was ended from outside")
    elif not replayed.end:
        yield Difference(recorded.ended_at, f"it goes on, where {_end(recorded)} was recorded")
    elif (recorded.end, recorded.error_code) != (replayed.end, replayed.error_code):
        yield Difference(replayed.ended_at, f"it ends as {_end(replayed)}; recorded was {_end(recorded)}")


def _end(course: Course) -> str:
    return f"{course.end} ({course.error_code})" if course.error_code else course.end or "nothing"


def _velocities(recorded: Course, replayed: Course) -> Iterator[Difference]:
    """Yield one sentence for each time span in which other velocities are commanded."""
    until = min(recorded.ended_at, replayed.ended_at)
    times = [at for at, _ in recorded.velocities]
    began: float | None = None
    last, worst = 0.0, (STANDSTILL, STANDSTILL)
    for at, velocity in [*replayed.velocities, (math.inf, STANDSTILL)]:
        other = _nearest(recorded, times, at, velocity) if at <= until else velocity
        if _same(other, velocity):
            if began is not None and last - began >= BRIEF:
                yield _span(began, last, *worst)
            began = None
            continue
        if began is None:
            began, worst = at, (velocity, other)
        elif _apart(velocity, other) > _apart(*worst):
            worst = velocity, other
        last = at


def _nearest(recorded: Course, times: list[float], at: float, velocity: Velocity) -> Velocity:
    """Return the recorded velocity around a moment that is nearest to another one."""
    low, high = bisect_left(times, at - AROUND), bisect_right(times, at + AROUND)
    around = [each for _, each in recorded.velocities[low:high]]
    before = recorded.velocities[low - 1] if low else (-math.inf, STANDSTILL)
    around.append(before[1] if at - AROUND - before[0] <= HELD else STANDSTILL)
    return min(around, key=lambda each: _apart(each, velocity))


def _apart(one: Velocity, other: Velocity) -> float:
    linear = max(abs(one.linear_x - other.linear_x), abs(one.linear_y - other.linear_y))
    return max(linear / LINEAR, abs(one.angular_z - other.angular_z) / ANGULAR)


def _same(one: Velocity, other: Velocity) -> bool:
    return _apart(one, other) <= 1.0


def _span(began: float, last: float, now: Velocity, then: Velocity) -> Difference:
    how = f"another velocity until {last:.1f} s: up to {_words(now)}, where {_words(then)} were recorded"
    return Difference(began, how)


def _words(velocity: Velocity) -> str:
    return f"{velocity.linear_x:.2f} m/s and {velocity.angular_z:.2f} rad/s"
