"""Finds where a recorded robot stuttered: its server or its odometry was held up, as on a busy machine.

What the server decided there depends on which message came just before which, and that is not in a recording.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

HELD_UP = (0.2, 1.5)
"""Seconds between two control steps, or two messages of odometry: in between, the server may have stopped the robot for
the gap. After a longer one it surely has."""
USUAL = 2.5
"""Times as long as most of what follows quickly: so much jitter is usual."""
ECHO = 5.0
"""Seconds after that in which the robot may still drive otherwise for it."""


class Stutter(NamedTuple):
    """Something that was held up: when, for how long, in seconds, and what it was."""

    at: float
    seconds: float
    what: str


def stutter_before(at: float, times: Sequence[float], what: str) -> Stutter | None:
    """Return the last stutter that a difference may follow from; None if there was none.

    Args:
        at: When the difference begins, in seconds since the goal was accepted.
        times: When there were control steps, or messages, in order.
        what: What these are.
    """
    gaps = [(begin, end - begin) for begin, end in pairwise(times)]
    if not gaps:
        return None
    quick = sorted(gap for _, gap in gaps)[len(gaps) // 5]
    least, most = max(HELD_UP[0], USUAL * quick), HELD_UP[1]
    found = [
        Stutter(begin, gap, what) for begin, gap in gaps if least <= gap <= most and begin <= at <= begin + gap + ECHO
    ]
    return found[-1] if found else None
