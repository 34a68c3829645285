import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.observation import InfraredReading
from docking.estimation.receivers import CONFIRMED, Sight, find_sector, ranges_of
from docking.parameters import Receivers

RECEIVERS = Receivers()


@given(st.floats(-1.0, 1.0))
def test_the_bearing_is_in_the_sector_that_is_seen(bearing: float) -> None:
    seen = [abs(bearing - direction) <= RECEIVERS.half for direction in RECEIVERS.directions]
    sector = find_sector(seen, RECEIVERS)
    if sector is None:
        assert abs(bearing) > RECEIVERS.infrared_receiver_angle + RECEIVERS.half
    else:
        assert sector[0] <= bearing <= sector[1]
        assert sector[1] - sector[0] < math.radians(21)


@given(st.lists(st.sampled_from([True, False, None]), min_size=3, max_size=3), st.floats(-1.0, 1.0))
def test_a_receiver_of_which_nothing_is_known_excludes_nothing(known: list[bool | None], bearing: float) -> None:
    truth = [abs(bearing - direction) <= RECEIVERS.half for direction in RECEIVERS.directions]
    seen = [None if mask is None else sees for mask, sees in zip(known, truth, strict=True)]
    sector = find_sector(seen, RECEIVERS)
    assert sector is None or sector[0] <= bearing <= sector[1]


def test_nothing_seen_is_no_sector() -> None:
    assert find_sector([False, None, False], RECEIVERS) is None


def test_left_and_right_alone_see_nothing_together() -> None:
    narrow = Receivers(infrared_field_of_view=0.4)
    assert find_sector([True, None, True], narrow) is None


def test_too_near_to_tell_is_0_and_unseen_is_infinite() -> None:
    assert ranges_of(InfraredReading(math.inf, -math.inf, 0.3, 0.0)) == (math.inf, 0.0, 0.3)


def test_nothing_is_in_sight_before_two_readings_agree() -> None:
    sight = Sight()
    assert [sight.update(seen, number / 15) for number, seen in enumerate([True, False, True])] == [None] * 3
    assert sight.seen is None
    assert sight.update(True, 0.2) is None
    assert sight.seen is True


def test_a_single_reading_changes_nothing() -> None:
    sight = Sight()
    seen = [True, True, False, True, True, False, True]
    assert [sight.update(sees, number / 15) for number, sees in enumerate(seen)] == [None] * len(seen)
    assert sight.seen is True


def test_a_change_is_dated_between_the_readings_around_it() -> None:
    sight = Sight()
    changes = [sight.update(sees, float(number)) for number, sees in enumerate([True, True] + [False] * CONFIRMED)]
    assert changes[:-1] == [None] * (len(changes) - 1)
    change = changes[-1]
    assert change is not None
    assert (change.seen, change.before, change.after) == (False, 1.0, 2.0)
    assert change.stamp == pytest.approx(1.5)
    assert change.gap == pytest.approx(1.0)
