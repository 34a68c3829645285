"""Where the robot was when something was seen."""

import math

import pytest

from docking.core.geometry import Pose
from docking.core.observation import Odometry, Velocity
from docking.estimation.track import AHEAD, KEPT, Track


def odometry(x: float, theta: float = 0.0, *, stamp: float, velocity: Velocity | None = None) -> Odometry:
    return Odometry(Pose(x, 0.0, theta), velocity or Velocity(), stamp)


def test_it_interpolates_between_two_measurements() -> None:
    track = Track()
    track.add(1000.0, odometry(1.0, 3.0, stamp=5.0))
    track.add(1000.1, odometry(2.0, -3.0, stamp=5.2))  # across pi, 0.283 rad on
    middle = track.at(1000.05)
    assert middle.pose.x == pytest.approx(1.5)
    assert abs(middle.pose.theta) == pytest.approx(math.pi)
    assert middle.stamp == pytest.approx(5.1)
    assert track.at(1000.0).pose == Pose(1.0, 0.0, 3.0)
    assert track.at(1000.1).pose.x == pytest.approx(2.0)


def test_it_goes_on_as_the_robot_did_for_a_moment() -> None:
    track = Track()
    track.add(10.0, odometry(1.0, stamp=5.0, velocity=Velocity(0.2, 0.5)))
    ahead = track.at(10.1)
    assert (ahead.pose.x, ahead.pose.theta) == (pytest.approx(1.02), pytest.approx(0.05))
    assert ahead.stamp == pytest.approx(5.1)
    with pytest.raises(LookupError, match=r"0\.3 s after the latest odometry"):
        track.at(10.0 + AHEAD + 0.05)


def test_what_lies_too_far_back_is_not_known() -> None:
    track = Track()
    for step in range(100):
        track.add(10.0 + step / 20, odometry(float(step), stamp=step / 20))
    newest = 10.0 + 99 / 20
    assert track.at(newest - KEPT + 0.01).pose.x == pytest.approx(99 - 20 * (KEPT - 0.01))
    with pytest.raises(LookupError, match=r"3\.0 s before the latest odometry"):
        track.at(newest - 3.0)


def test_a_moment_just_before_the_first_measurement_is_that_measurement() -> None:
    track = Track()
    track.add(10.0, odometry(1.0, stamp=5.0))
    assert track.at(9.9) == odometry(1.0, stamp=5.0)


def test_a_stamp_that_was_not_set_is_now() -> None:
    track = Track()
    track.add(10.0, odometry(1.0, stamp=5.0))
    assert track.at(0.0) is track.latest


def test_there_is_nothing_before_the_first_measurement() -> None:
    track = Track()
    assert track.latest is None
    with pytest.raises(LookupError, match="before any odometry"):
        track.at(0.0)


def test_a_clock_that_begins_anew_begins_the_track_anew() -> None:
    track = Track()
    track.add(1000.0, odometry(1.0, stamp=5.0))
    track.add(3.0, odometry(2.0, stamp=5.1))
    assert track.at(3.0).pose.x == 2.0
    with pytest.raises(LookupError):
        track.at(1000.0)


def test_two_measurements_of_one_moment_do_no_harm() -> None:
    track = Track()
    for x in (1.0, 2.0):
        track.add(10.0, odometry(x, stamp=5.0))
    track.add(10.1, odometry(3.0, stamp=5.1))
    assert track.at(10.0).pose.x == 2.0


@pytest.mark.parametrize("measured_at", [0.0, 12.5])
def test_a_clock_that_stands_still_fills_no_memory(measured_at: float) -> None:
    track = Track()
    for number in range(100):
        track.add(measured_at, odometry(float(number), stamp=number / 20))
    assert len(track) == 1
    assert track.at(0.0).pose.x == track.at(measured_at).pose.x == 99.0


def test_what_was_measured_belongs_to_odometry_of_its_moment_whenever_that_arrives() -> None:
    track = Track()
    assert track.arrival(10.0, received=5.3) == 5.3
    for number in range(3):
        track.add(10.0 + 0.1 * number, odometry(1.0, stamp=5.2 + 0.1 * number))
    assert track.arrival(10.05, received=5.4) == pytest.approx(5.25)
    assert track.arrival(10.3, received=5.4) == pytest.approx(5.5), "odometry is 0.1 s late"
    assert track.arrival(0.0, received=5.4) == 5.4, "no stamp"
    assert [track.arrival(wrong, received=5.4) for wrong in (8.0, 9.7, 12.0)] == [5.4] * 3, "another clock"


def test_a_message_that_is_repeated_with_its_stamp_says_nothing_new() -> None:
    track = Track()
    track.add(4.9, Odometry(Pose(0.98), Velocity(0.2), 9.9))
    for received in (10.0, 10.1, 10.2):
        track.add(5.0, Odometry(Pose(1.0), Velocity(0.2), received))
    assert track.latest == Odometry(Pose(1.0), Velocity(0.2), 10.0)
    track.add(5.0, Odometry(Pose(1.1), Velocity(0.2), 10.3))
    assert track.latest == Odometry(Pose(1.1), Velocity(0.2), 10.3), "a clock that stands still"


@pytest.mark.parametrize("stamp", [0.0, 7.0])
def test_a_stamp_that_never_went_on_does_not_make_messages_old(stamp: float) -> None:
    track = Track()
    for received in (10.4, 10.5):
        track.add(stamp, Odometry(Pose(1.1), Velocity(), received))
    assert track.latest == Odometry(Pose(1.1), Velocity(), 10.5)
