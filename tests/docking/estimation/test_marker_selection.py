from docking.core.geometry import Pose
from docking.estimation.marker_selection import DOUBTED, MarkerSelection

DOCK, OTHER, ROBOT = Pose(2.0, 0.0), Pose(2.0, 0.9), Pose()


def look(selection: MarkerSelection, markers: list[Pose]) -> tuple[bool, bool]:
    """Whether the marker of the dock was taken, and whether there was ever doubt."""
    taken = doubted = False
    for marker in markers:
        taken |= selection.takes(marker, ROBOT, None) and marker is DOCK
        doubted |= selection.ambiguous is not None
    return taken, doubted


def test_a_reflection_that_is_seen_often_at_first_leaves_no_doubt() -> None:
    first, later = [OTHER, DOCK] * 5, [OTHER, *[DOCK] * 6] * 10
    assert look(MarkerSelection(), first + later) == (True, False)


def test_two_markers_that_are_seen_equally_often_leave_doubt() -> None:
    selection = MarkerSelection()
    look(selection, [DOCK, OTHER] * (DOUBTED - 1))
    assert selection.ambiguous is None
    assert look(selection, [DOCK, OTHER]) == (False, True)


def test_where_the_dock_is_expected_there_is_no_doubt() -> None:
    selection = MarkerSelection()
    selection.expect(DOCK)
    assert look(selection, [DOCK, OTHER] * DOUBTED) == (True, False)
    assert selection.left_out == DOUBTED
