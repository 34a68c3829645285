"""What was held up shortly before a difference."""

from docking.replay.stutter import ECHO, Stutter, stutter_before


def times(*gaps: float) -> list[float]:
    """Twenty moments in a second, with a gap at each whole second."""
    found, at = [0.0], 0.0
    for gap in gaps:
        found += [at + each / 20 for each in range(1, 20)]
        at += 1.0
        found.append(at - 0.05 + gap)
        at += gap
    return found


def test_a_moment_without_messages_before_a_difference_counts() -> None:
    held_up = times(0.0, 0.5, 0.0)
    found = stutter_before(3.0, held_up, "odometry")
    assert isinstance(found, Stutter)
    assert (round(found.at, 2), round(found.seconds, 2), found.what) == (1.95, 0.5, "odometry")
    assert stutter_before(1.5, held_up, "odometry") is None, "what comes later caused nothing"
    assert stutter_before(2.45 + ECHO + 0.1, held_up, "odometry") is None, "it is long ago"


def test_what_comes_regularly_or_not_at_all_does_not() -> None:
    assert stutter_before(3.0, times(0.0, 0.0, 0.0), "the server") is None
    assert stutter_before(9.0, times(0.0, 5.0, 0.0), "odometry") is None, "the server surely noticed"
    assert stutter_before(3.0, [], "odometry") is None
    assert stutter_before(3.0, [each / 4 for each in range(20)], "odometry") is None, "it is slow"
