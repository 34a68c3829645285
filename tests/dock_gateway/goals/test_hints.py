"""What a robot without a docking server is told."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.goals.hints import Sight, docking_hint, find_join, split_robots

BASE = Sight("/robot1", battery="/robot1/battery_status")
SERVER = Sight("/docking", dock="/docking/dock_robot", undock="/docking/undock_robot")
WHOLE = Sight("/robot2", dock="/robot2/dock", battery="/robot2/battery_status")
LINES = [
    'robots."/robot1".dock_action = "/docking/dock_robot"',
    'robots."/robot1".undock_action = "/docking/undock_robot"',
]
NESTED = Sight("/robot1/docking", dock="/robot1/docking/dock")
OTHER = Sight("/docking2", dock="/docking2/dock_robot")


def test_both_halves_and_the_lines_that_join_them() -> None:
    for robot in ("/robot1", "/", "/robot9"):
        hint = docking_hint(robot, [BASE, SERVER, Sight("/")])
        assert hint is not None
        assert (hint.settings, hint.robots) == (LINES, [])
        for part in ("/docking/dock_robot", "/robot1/battery_status", LINES[0], "/robot1"):
            assert part in hint.detail
        assert ("?robot=/robot1" in hint.detail) is (robot != "/robot1")


def test_robots_that_can_dock_are_named() -> None:
    hint = docking_hint("/", [Sight("/"), WHOLE])
    assert hint is not None
    assert (hint.settings, hint.robots) == ([], ["/robot2"])
    assert "?robot=/robot2" in hint.detail
    assert docking_hint("/", [Sight("/")]) is None
    assert docking_hint("/robot1", [BASE]) is None


def test_nothing_is_guessed_among_several() -> None:
    assert find_join("/robot1", [BASE, SERVER, OTHER]) is None
    hint = docking_hint("/robot1", [BASE, SERVER, OTHER])
    assert hint is not None
    assert hint.settings == []
    assert 'robots."/robot1".dock_action = "/its/name"' in hint.detail
    nested = find_join("/robot1", [BASE, SERVER, NESTED])
    assert nested is not None
    assert nested.settings == ['robots."/robot1".dock_action = "/robot1/docking/dock"']


@pytest.mark.parametrize(
    ("sights", "split"),
    [
        ([BASE, SERVER], [("/robot1", "/docking")]),
        ([BASE, SERVER, Sight("/")], [("/robot1", "/docking")]),
        ([BASE, SERVER, WHOLE], []),
        ([BASE, NESTED, WHOLE, OTHER], [("/robot1", "/robot1/docking")]),
        ([BASE, WHOLE], []),
        ([SERVER, WHOLE], []),
        ([BASE, SERVER, OTHER], []),
    ],
)
def test_robots_that_are_probably_split(sights: list[Sight], split: list[tuple[str, str]]) -> None:
    assert [(each.robot, each.other) for each in split_robots(sights)] == split


names = st.sampled_from(["/", "/a", "/a/b", "/c", "/c/d/e"])
sights = st.lists(
    st.builds(
        lambda robot, dock, battery: Sight(
            robot, f"{robot}/dock" if dock else None, None, f"{robot}/battery" if battery else None
        ),
        names,
        st.booleans(),
        st.booleans(),
    ),
    unique_by=lambda sight: sight.robot,
)


@given(sights, names)
def test_no_docking_server_of_a_robot_with_a_battery_is_offered_to_another(found: list[Sight], robot: str) -> None:
    hint = docking_hint(robot, found)
    taken = {each.dock for each in found if each.dock and each.battery}
    lines = [] if hint is None else hint.settings
    assert not [line for line in lines if line.rpartition("=")[2] in taken]
    assert all(line.split("=")[1] != "/its" for line in lines)
