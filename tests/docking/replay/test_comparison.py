"""Where two courses of a goal differ."""

from docking.core.observation import Velocity
from docking.replay.comparison import differences
from docking.replay.course import Course

AHEAD, LEFT = Velocity(0.2, 0.0), Velocity(0.0, 0.5)


def course(*stages: tuple[float, str], speeds: dict[float, Velocity] | None = None, end: str = "SUCCEEDED") -> Course:
    """A course of 10 s, in which the robot drives ahead but where `speeds` say otherwise; its steps take 0.1 s."""
    velocities, now = [], AHEAD
    for step in range(100):
        now = (speeds or {}).get(step / 10, now)
        velocities.append((step / 10, now))
    end, _, code = end.partition(" ")
    return Course(list(stages or [(0.0, "CONTROLLING")]), velocities, end, code, ended_at=10.0)


def test_the_same_course() -> None:
    assert differences(course(), course()) == []


def test_what_is_brief_does_not_count() -> None:
    recorded = course((0.0, "CONTROLLING"), (5.0, "RETRY"))
    replayed = course((0.0, "CONTROLLING"), (4.3, "WAIT_FOR_CHARGE"), (4.9, "CONTROLLING"), (5.6, "RETRY"))
    replayed.velocities = [(at + 0.07, LEFT if 4.3 < at < 4.9 else speed) for at, speed in replayed.velocities]
    assert differences(recorded, replayed) == []


def test_other_stages() -> None:
    recorded = course((0.0, "INITIAL_PERCEPTION"), (2.0, "CONTROLLING"), (6.0, "RETRY"))
    (late,) = differences(recorded, course((0.0, "INITIAL_PERCEPTION"), (3.5, "CONTROLLING"), (6.0, "RETRY")))
    assert "CONTROLLING comes at 3.5 s" in late.how
    (missing,) = differences(recorded, course((0.0, "INITIAL_PERCEPTION"), (2.0, "CONTROLLING")))
    assert "RETRY does not come" in missing.how
    (other,) = differences(recorded, course((0.0, "INITIAL_PERCEPTION"), (2.0, "RETRY"), (6.0, "CONTROLLING")))
    assert "RETRY comes (2.0 s) instead of CONTROLLING (2.0 s)" in other.how


def test_another_velocity() -> None:
    (found,) = differences(course(), course(speeds={3.0: LEFT, 5.0: AHEAD}))
    assert str(found).startswith("   3.0 s  another velocity until 4.9 s: up to 0.00 m/s and 0.50 rad/s")


def test_other_ends() -> None:
    (other,) = differences(course(end="ABORTED LOST_MARKER"), course())
    assert "it ends as SUCCEEDED; recorded was ABORTED (LOST_MARKER)" in other.how
    (on,) = differences(course(), course(end=""))
    assert "it goes on, where SUCCEEDED was recorded" in on.how


def test_an_end_from_outside_is_nobody_s_decision() -> None:
    for end in ("CANCELED", "ABORTED STOP_LATCHED"):
        assert differences(course(end=end), course(end="")) == []
        (early,) = differences(course(end=end), course())
        assert "before it was ended from outside" in early.how
