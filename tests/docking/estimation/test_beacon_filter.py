import math
from collections.abc import Iterable
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.behaviors.sidestep import passing_rate
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, InfraredReading, Observation, Odometry
from docking.estimation.beacon_filter import BeaconFilter
from docking.parameters import MotionLimits, Receivers

INF = math.inf
BEACON = Pose(1.0, 0.3)
RECEIVERS = Receivers()
PERIOD = 1.0 / 15.0


def reading(robot: Pose, beacon: Pose = BEACON, stamp: float = 0.0) -> InfraredReading:
    """What ideal receivers see of a beacon that shines in all directions."""
    receivers = RECEIVERS.position(robot)
    distance = receivers.distance_to(beacon)
    bearing = normalize_angle(math.atan2(beacon.y - receivers.y, beacon.x - receivers.x) - robot.theta)
    left, center, right = (distance if abs(bearing - way) <= RECEIVERS.half else INF for way in RECEIVERS.directions)
    return InfraredReading(left, center, right, stamp)


def observed(odometry: Pose, now: float, seen: InfraredReading) -> Observation:
    return Observation(now, odometry=Odometry(odometry, STANDSTILL, now), infrared=seen)


def looking_around(x: float, y: float, count: int = 150) -> Iterable[Pose]:
    """A robot that turns to and fro in front of the beacon."""
    towards = math.atan2(BEACON.y - y, BEACON.x - x)
    return (Pose(x, y, towards + 0.4 * math.sin(number / 15)) for number in range(count))


def run(beacon_filter: BeaconFilter, poses: Iterable[Pose], start: float = 0.0) -> float:
    """Perfect odometry and readings; returns the moment after the last one."""
    now = start
    for pose in poses:
        beacon_filter.update(observed(pose, now, reading(pose, stamp=now)))
        now += PERIOD
    return now


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
def test_turning_to_and_fro_finds_the_beacon(x: float, y: float) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    run(beacon_filter, looking_around(x, y))
    assert beacon_filter.position is not None
    assert beacon_filter.position.distance_to(BEACON) < 0.03


def test_turning_to_and_fro_shows_that_odometry_measures_turns_too_large() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    now = 0.0
    for pose in looking_around(0.0, 0.0, 200):
        seen = reading(pose, stamp=now)
        beacon_filter.update(observed(Pose(0.0, 0.0, 1.1 * pose.theta), now, seen))
        now += PERIOD
    turned = pose.theta - 0.5  # without a reading
    robot = Pose(0.0, 0.0, 1.1 * turned)
    beacon_filter.update(Observation(now, odometry=Odometry(robot, STANDSTILL, now)))
    receivers = RECEIVERS.position(Pose(0.0, 0.0, turned))
    bearing = math.atan2(BEACON.y - receivers.y, BEACON.x - receivers.x) - turned
    assert beacon_filter.bearing(robot) == pytest.approx(bearing, abs=0.01)


def test_late_odometry_is_waited_for() -> None:
    prompt, late = BeaconFilter(RECEIVERS), BeaconFilter(RECEIVERS)
    poses = list(looking_around(0.0, 0.0))
    run(prompt, poses)
    for number, pose in enumerate(poses):
        now = PERIOD * number
        seen = reading(pose, stamp=now + 3 * PERIOD)  # when odometry of its moment will arrive
        late.update(observed(poses[max(0, number - 3)], now, seen))
    assert late.heard_at == pytest.approx(PERIOD * (len(poses) - 1))
    assert prompt.position is not None
    assert late.position is not None
    assert late.position.distance_to(prompt.position) < 0.01


@pytest.mark.parametrize("ghosts", [0.02, 0.1])
def test_ghosts_move_the_beacon_nowhere(ghosts: float) -> None:
    random = Random(3)
    beacon_filter = BeaconFilter(RECEIVERS)
    now = 0.0
    for pose in looking_around(0.2, 0.0, 300):
        seen = reading(pose, stamp=now)
        ranges = [random.uniform(0.02, 2.0) if random.random() < ghosts else distance for distance in seen_by(seen)]
        beacon_filter.update(observed(pose, now, InfraredReading(*ranges, now)))
        now += PERIOD
    assert beacon_filter.position is not None
    assert beacon_filter.position.distance_to(BEACON) < 0.04


def test_ghosts_alone_are_no_beacon() -> None:
    random = Random(3)
    beacon_filter = BeaconFilter(RECEIVERS)
    for number in range(600):
        ranges = [random.uniform(0.02, 2.0) if random.random() < 0.1 else INF for _ in range(3)]
        beacon_filter.update(observed(Pose(), number * PERIOD, InfraredReading(*ranges, number * PERIOD)))
    assert not beacon_filter.known


def test_a_beacon_that_is_somewhere_else_is_found_there_and_its_axis_is_unknown() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    now = run(beacon_filter, looking_around(0.0, 0.0))
    beacon_filter.confirm_edge(1, beacon_filter.angle)
    assert beacon_filter.axis is not None
    moved = Pose(0.6, 0.2)
    for number in range(30):
        at = now + number * PERIOD
        beacon_filter.update(observed(Pose(), at, reading(Pose(), moved, at)))
    assert beacon_filter.position is not None
    assert beacon_filter.position.distance_to(moved) < 0.1
    assert beacon_filter.axis is None


def test_a_beacon_that_is_hidden_and_seen_again_is_where_it_was() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    now = run(beacon_filter, looking_around(0.0, 0.0))
    before = beacon_filter.position
    assert before is not None
    robot = Pose(0.0, 0.0, beacon_filter.line_of_sight(Pose()) - 0.35)
    for number in range(60):
        at = now + number * PERIOD
        hidden = number % 20 < 8
        seen = InfraredReading(INF, INF, INF, at) if hidden else reading(robot, stamp=at)
        beacon_filter.update(observed(robot, at, seen))
    assert beacon_filter.position is not None
    assert beacon_filter.position.distance_to(before) < 0.02
    assert {crossing.lit for crossing in beacon_filter.crossings} == {True, False}


@given(st.sampled_from([-1, 1]))
def test_an_edge_of_the_light_gives_the_axis(side: int) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    run(beacon_filter, looking_around(0.0, 0.0))
    assert beacon_filter.axis is None
    assert beacon_filter.axis_error > 1.0
    beacon_filter.confirm_edge(side, beacon_filter.angle)
    line_of_sight = seen_from_the_last()
    # Looking at the dock, its right-hand edge is a robot's whose line of sight is turned to the left of the axis.
    assert beacon_filter.axis == pytest.approx(line_of_sight - side * RECEIVERS.infrared_beacon_angle, abs=0.03)
    assert beacon_filter.axis_error < 0.04


def test_with_both_edges_it_does_not_matter_how_wide_the_light_is() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    run(beacon_filter, looking_around(0.0, 0.0))
    angle, wide = beacon_filter.angle, 2.0 * RECEIVERS.infrared_beacon_angle + 0.04
    beacon_filter.confirm_edge(1, angle)
    alone = beacon_filter.axis_error
    beacon_filter.confirm_edge(-1, angle - wide)
    assert beacon_filter.edges == {-1, 1}
    assert beacon_filter.axis == pytest.approx(seen_from_the_last() - 0.5 * wide, abs=0.02)
    assert beacon_filter.axis_error < alone


def test_an_edge_that_contradicts_the_other_one_replaces_it() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    run(beacon_filter, looking_around(0.0, 0.0))
    beacon_filter.confirm_edge(1, beacon_filter.angle - 0.6)
    beacon_filter.confirm_edge(-1, beacon_filter.angle)
    assert beacon_filter.edges == {-1}
    expected = seen_from_the_last() + RECEIVERS.infrared_beacon_angle
    assert beacon_filter.axis == pytest.approx(expected, abs=0.04)


@given(
    st.lists(st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 3), min_size=1, max_size=12),
    st.floats(-3.0, 3.0),
)
def test_no_reading_makes_it_something_else_than_numbers(
    several: list[tuple[float, float, float]], theta: float
) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    for number in range(24):
        now = number * PERIOD
        ranges = several[number % len(several)]
        pose = Pose(0.01 * number, 0.0, theta + 0.02 * number)
        beacon_filter.update(observed(pose, now, InfraredReading(*ranges, now)))
    assert beacon_filter.position is None or beacon_filter.position.finite


def test_a_beacon_right_at_the_receivers_is_no_division_by_zero() -> None:
    assert math.isfinite(passing_rate(MotionLimits().v_linear_max, RECEIVERS.infrared_receiver_angle, 0.0))


def seen_from_the_last() -> float:
    """The direction to the beacon from the receivers after looking around at the origin."""
    *_, last = looking_around(0.0, 0.0)
    receivers = RECEIVERS.position(last)
    return math.atan2(BEACON.y - receivers.y, BEACON.x - receivers.x)


def seen_by(seen: InfraredReading) -> tuple[float, float, float]:
    return seen.left, seen.center, seen.right
