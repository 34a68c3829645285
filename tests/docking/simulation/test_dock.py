import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.simulation.dock import DOCKED, Dock, DockSettings

DOCK = Dock(DockSettings())
RADIUS = 0.15
NEAR = st.floats(min_value=-0.6, max_value=0.6)


@pytest.mark.parametrize(
    ("x", "y", "degrees", "contact"),
    [
        (0.0, 0.0, 0.0, True),
        (-0.0199, 0.0, 0.0, True),
        (-0.0201, 0.0, 0.0, False),
        (0.0, 0.0199, 0.0, True),
        (0.0, -0.0201, 0.0, False),
        (-0.0141, 0.0141, 0.0, True),
        (-0.0143, 0.0143, 0.0, False),
        (0.0, 0.0, 4.99, True),
        (0.0, 0.0, 5.01, False),
        (0.0, 0.0, -4.99, True),
        (0.0, 0.0, -5.01, False),
        (0.0, 0.0, 360.0 + 4.99, True),
        (0.0, 0.0, 180.0, False),
    ],
)
def test_contact_is_within_two_centimetres_and_five_degrees(x: float, y: float, degrees: float, contact: bool) -> None:
    assert DOCK.in_contact(DOCKED.x + x, DOCKED.y + y, DOCKED.theta + math.radians(degrees)) is contact


def test_the_whole_contact_zone_that_can_be_reached_head_on_is_free() -> None:
    for millimetres in range(-20, 10):
        assert DOCK.boxes[0].obstruct(DOCKED.x + millimetres / 1000.0, 0.0, RADIUS) is None
    assert DOCK.boxes[0].obstruct(DOCKED.x + 0.011, 0.0, RADIUS) is not None


@given(NEAR, NEAR)
def test_what_would_be_inside_is_kept_outside_and_close_by(x: float, y: float) -> None:
    obstruction = DOCK.boxes[0].obstruct(x, y, RADIUS)
    if obstruction is None:
        assert DOCK.clearance(x, y) >= RADIUS - 1e-9
        return
    assert DOCK.clearance(x, y) < RADIUS
    assert DOCK.clearance(obstruction.x, obstruction.y) == pytest.approx(RADIUS)
    assert math.hypot(obstruction.normal_x, obstruction.normal_y) == pytest.approx(1.0)
    assert math.hypot(obstruction.x - x, obstruction.y - y) <= RADIUS + 0.1 + 1e-9, "by the nearest way"


def test_a_corner_pushes_away_from_itself() -> None:
    obstruction = DOCK.boxes[0].obstruct(-0.1, 0.2, RADIUS)
    assert obstruction is not None
    assert obstruction.normal_x < 0.0 < obstruction.normal_y
