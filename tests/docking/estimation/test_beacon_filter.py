import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.behaviors.sidestep import Sidestep
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, InfraredReading, Observation, Odometry, Velocity
from docking.estimation.beacon_filter import BeaconFilter, find_sector
from docking.parameters import MotionLimits, Receivers

INF = math.inf
BEACON = Pose(1.0, 0.3)
RECEIVERS = Receivers()


def reading(robot: Pose, beacon: Pose = BEACON, stamp: float = 0.0) -> InfraredReading:
    """What ideal receivers see."""
    receivers = RECEIVERS.position(robot)
    distance = receivers.distance_to(beacon)
    bearing = normalize_angle(math.atan2(beacon.y - receivers.y, beacon.x - receivers.x) - robot.theta)
    half = 0.5 * RECEIVERS.infrared_field_of_view
    angle = RECEIVERS.infrared_receiver_angle
    left, center, right = (distance if abs(bearing - way) <= half else INF for way in (angle, 0.0, -angle))
    return InfraredReading(left, center, right, stamp)


def observed(robot: Pose, now: float) -> Observation:
    return Observation(now, odometry=Odometry(robot, STANDSTILL, now), infrared=reading(robot, stamp=now))


@given(st.floats(-1.0, 1.0))
def test_the_bearing_is_in_the_sector_that_is_seen(bearing: float) -> None:
    beacon = Pose(RECEIVERS.infrared_receiver_x + math.cos(bearing), math.sin(bearing))
    sector = find_sector(reading(Pose(), beacon), RECEIVERS)
    if sector is None:
        assert abs(bearing) > RECEIVERS.infrared_receiver_angle + 0.5 * RECEIVERS.infrared_field_of_view - 1e-9
    else:
        assert sector[0] - 1e-9 <= bearing <= sector[1] + 1e-9
        assert sector[1] - sector[0] < math.radians(21)


@pytest.mark.parametrize("unseen", [INF, math.nan])
def test_nothing_seen_is_no_sector(unseen: float) -> None:
    assert find_sector(InfraredReading(unseen, unseen, unseen, 0.0), RECEIVERS) is None


def test_too_near_to_tell_is_seen() -> None:
    sector = find_sector(InfraredReading(INF, -INF, INF, 0.0), RECEIVERS)
    assert sector is not None
    assert sector[0] < 0.0 < sector[1]


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_turning_to_and_fro_finds_the_beacon(x: float, y: float) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    towards = math.atan2(BEACON.y - y, BEACON.x - x)
    for number in range(200):
        heading = towards + 0.35 * math.sin(number / 15)
        beacon_filter.update(observed(Pose(x, y, heading), number / 15))
    assert beacon_filter.position is not None
    assert beacon_filter.position.distance_to(BEACON) < 0.04


@given(st.floats(-math.pi, math.pi), st.floats(0.3, 1.0), st.sampled_from([-1, 1]))
def test_an_edge_of_the_light_gives_the_axis(axis: float, distance: float, side: int) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    beacon_filter.position = BEACON
    assert beacon_filter.axis is None
    # Looking at the dock, its right-hand edge is a robot's whose line of sight is turned to the left of the axis.
    line_of_sight = axis + side * RECEIVERS.infrared_beacon_angle
    edge = Pose(BEACON.x - distance * math.cos(line_of_sight), BEACON.y - distance * math.sin(line_of_sight))
    beacon_filter.edges[side] = edge
    assert beacon_filter.axis is not None
    assert normalize_angle(beacon_filter.axis - axis) == pytest.approx(0.0, abs=1e-9)


def test_with_both_edges_it_does_not_matter_how_wide_the_light_is() -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    beacon_filter.position = Pose()
    for side in (-1, 1):
        line_of_sight = 0.4 + side * math.radians(50.0)
        beacon_filter.edges[side] = Pose(-math.cos(line_of_sight), -math.sin(line_of_sight))
    assert beacon_filter.axis == pytest.approx(0.4)


@given(st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 3), st.floats(-3.0, 3.0))
def test_no_reading_makes_it_something_else_than_numbers(ranges: tuple[float, float, float], theta: float) -> None:
    beacon_filter = BeaconFilter(RECEIVERS)
    for number in range(3):
        now = float(number)
        odometry = Odometry(Pose(0.0, 0.0, theta), STANDSTILL, now)
        beacon_filter.update(Observation(now, odometry=odometry, infrared=InfraredReading(*ranges, now)))
    assert beacon_filter.position is None or beacon_filter.position.finite


def test_a_beacon_right_at_the_receivers_is_no_division_by_zero() -> None:
    step = Sidestep(BeaconFilter(RECEIVERS), MotionLimits(), 1)._drive(RECEIVERS.infrared_receiver_angle, 0.0)
    assert isinstance(step, Velocity)
    assert step.finite
