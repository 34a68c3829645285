"""Whose turn it is, and where a mission goes that is moved."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import Conflict, GatewayError
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.turns import (
    SPACING,
    RobotFacts,
    find_turns,
    in_turn,
    last_order,
    next_order,
    place,
    require_turn,
)
from tests.extensions.missions.examples import DOCK, NOON, after, queued


def members(group: str) -> set[str]:
    """Return the robots of a group."""
    return {"/", "/robot2"} if group == "pickers" else set()


def numbered(order: int, robot: str = "/", **fields: object) -> MissionEntry:
    """A mission with a number in the queue."""
    return queued(DOCK, robot=robot).model_copy(update={"order": order, **fields})


QUEUE = {
    "a": numbered(1),
    "b": numbered(2),
    "c": numbered(3),
    "urgent": numbered(9, priority=80),
    "other": numbered(0, "/robot1"),
}


def order_of(missions: dict[str, MissionEntry], robot: str = "/") -> list[str]:
    """Return the missions of a robot in the order in which they begin."""
    return [key for key, mission in in_turn(missions) if mission.robot == robot]


def test_the_highest_priority_begins_first_then_the_lowest_number() -> None:
    assert order_of(QUEUE) == ["urgent", "a", "b", "c"]
    turns = find_turns(QUEUE)
    assert turns.on == {"/": "urgent", "/robot1": "other"}
    assert turns.waits == {"a": "turn", "b": "turn", "c": "turn"}


def test_a_mission_that_is_on_its_way_has_its_robot_and_one_that_is_held_gives_way() -> None:
    held = numbered(0, status=MissionStatus.HELD)
    begun = progress.start(numbered(5), NOON)
    assert find_turns({**QUEUE, "begun": begun}).on == {"/": "begun", "/robot1": "other"}
    turns = find_turns({"held": held, "a": QUEUE["a"]})
    assert (turns.on, turns.waits) == ({"/": "a"}, {"held": "continue"})
    with pytest.raises(Conflict, match="another mission"):
        require_turn({**QUEUE, "begun": begun}, "urgent", "/")
    with pytest.raises(Conflict, match="comes first"):
        require_turn(QUEUE, "a", "/")
    require_turn({"held": held, **QUEUE}, "urgent", "/")


def for_group(order: int = 0, group: str = "pickers", **fields: object) -> MissionEntry:
    """A mission for one of a group, with a number in the queue."""
    return queued(DOCK, robot=None, group=group).model_copy(update={"order": order, **fields})


FREE = RobotFacts(groups=("pickers",), free=True, charge=0.5)


def test_a_mission_of_a_group_goes_to_the_free_robot_with_the_most_charge() -> None:
    robots = {
        "/busy": replace(FREE, charge=1.0),
        "/low": replace(FREE, charge=0.9, free=False),
        "/other": replace(FREE, charge=0.9, groups=("sweepers",)),
        "/b": replace(FREE, charge=0.7),
        "/a": replace(FREE, charge=0.7),
        "/c": replace(FREE, charge=0.6),
    }
    missions = {"busy": progress.start(numbered(0, "/busy"), NOON), "x": for_group(1), "y": for_group(2)}
    assert find_turns(missions, robots).on == {"/busy": "busy", "/a": "x", "/b": "y"}
    begun = progress.start(missions["x"], NOON, "/a")
    assert (begun.robot, begun.group, begun.status) == ("/a", "pickers", MissionStatus.RUNNING)


def test_the_queues_of_a_robot_and_of_its_group_are_one_order() -> None:
    own, group = numbered(5, "/a"), for_group(4)
    for missions, first in (
        ({"own": own, "group": group}, "group"),
        ({"own": own, "group": group.model_copy(update={"order": 6})}, "own"),
        ({"own": own.model_copy(update={"priority": 60}), "group": group}, "own"),
    ):
        turns = find_turns(missions, {"/a": FREE})
        assert turns.on == {"/a": first}
        assert turns.waits == ({"own": "turn"} if first == "group" else {"group": "robot"})


def test_why_a_mission_of_a_group_waits() -> None:
    held = for_group(status=MissionStatus.HELD)
    stopped = replace(FREE, stopped_at=after(1))
    for mission, robots, reason in (
        (for_group(), {}, "group"),
        (for_group(group="gone"), {"/a": FREE}, "group"),
        (for_group(), {"/a": RobotFacts(("pickers",))}, "robot"),
        (for_group(), {"/a": stopped}, "continue"),
        (held, {"/a": FREE}, "continue"),
    ):
        assert find_turns({"x": mission}, robots).waits == {"x": reason}
    let = for_group(allowed_at=after(2))
    assert find_turns({"x": let}, {"/a": stopped}).on == {"/a": "x"}


def test_a_mission_is_moved_within_the_queues_of_the_robots_that_may_take_it() -> None:
    missions = {"group": for_group(1), "again": for_group(2), "own": numbered(3), "gone": for_group(4, "gone")}
    missions |= {"gone too": for_group(5, "gone"), "elsewhere": numbered(6, "/robot1")}
    for moved, other, fits in (
        ("group", "own", True),
        ("own", "group", True),
        ("gone", "gone too", True),
        ("elsewhere", "group", False),
        ("gone", "group", False),
    ):
        if fits:
            assert place(missions, moved, other, members, before=False)
        else:
            with pytest.raises(Conflict) as refused:
                place(missions, moved, other, members, before=False)
            assert refused.value.code == "other_queue"


def test_a_new_mission_is_the_last_whatever_the_clock_says() -> None:
    assert next_order(0, NOON) == NOON.timestamp() * 1e6
    assert next_order(next_order(0, after(60)), NOON) == next_order(0, after(61))
    assert last_order(QUEUE) == 9
    assert last_order({"begun": progress.start(numbered(5), NOON)}) == 0


@pytest.mark.parametrize(
    ("moved", "other", "before", "expected"),
    [
        ("c", "a", True, ["urgent", "c", "a", "b"]),
        ("c", "a", False, ["urgent", "a", "c", "b"]),
        ("a", "c", False, ["urgent", "b", "c", "a"]),
        ("a", "b", True, ["urgent", "a", "b", "c"]),
        ("b", "a", False, ["urgent", "a", "b", "c"]),
        ("b", "b", True, ["urgent", "a", "b", "c"]),
        ("c", "urgent", True, ["c", "urgent", "a", "b"]),
        ("urgent", "a", False, ["a", "urgent", "b", "c"]),
    ],
)
def test_a_mission_is_moved_next_to_another_one(moved: str, other: str, before: bool, expected: list[str]) -> None:
    missions = dict(QUEUE)
    changes = place(missions, moved, other, members, before=before)
    missions.update(changes)
    assert order_of(missions) == expected
    assert missions[moved].priority == missions[other].priority
    assert (missions[moved].edition == 1) is (QUEUE[moved].priority != QUEUE[other].priority)
    assert place(missions, moved, other, members, before=before) == []


def test_what_cannot_be_moved() -> None:
    begun = progress.start(numbered(5), NOON)
    missions = {**QUEUE, "begun": begun, "ended": numbered(1, status=MissionStatus.CANCELED)}
    for moved, other, code in (
        ("a", "other", "other_queue"),
        ("begun", "a", "mission_begun"),
        ("a", "begun", "mission_begun"),
        ("a", "ended", "mission_not_found"),
        ("a", "nowhere", "mission_not_found"),
    ):
        with pytest.raises(GatewayError) as refused:
            place(missions, moved, other, members, before=True)
        assert refused.value.code == code


MISSIONS = st.lists(
    st.tuples(st.integers(0, 4) | st.integers(0, 4 * SPACING), st.sampled_from([50, 50, 50, 70])),
    min_size=2,
    max_size=8,
)
MOVES = st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7), st.booleans()), min_size=1, max_size=30)


@given(MISSIONS, MOVES, st.data())
def test_moves_keep_the_order_of_all_others_also_if_a_gateway_is_killed_in_between(
    numbers: list[tuple[int, int]], moves: list[tuple[int, int, bool]], data: st.DataObject
) -> None:
    """Numbers may be the same, or have no room between them."""
    missions = {f"{at}": numbered(order, priority=priority) for at, (order, priority) in enumerate(numbers)}
    for first, second, before in moves:
        moved, other = f"{first % len(missions)}", f"{second % len(missions)}"
        others = [key for key in order_of(missions) if key != moved]
        changes = place(missions, moved, other, members, before=before)
        made = data.draw(st.integers(0, len(changes))) if data.draw(st.integers(0, 5)) == 0 else len(changes)
        for at in range(made):
            key, changed = changes[at]
            assert changed.revision == missions[key].revision + 1
            missions[key] = changed
            if at + 1 < len(changes):  # what is left is the same, unless the room that was made is all that it needed
                assert place(missions, moved, other, members, before=before) in ([], changes[at + 1 :])
            assert [each for each in order_of(missions) if each != moved] == others
        line = order_of(missions)
        if moved != other and made == len(changes):
            assert line.index(moved) == line.index(other) + (-1 if before else 1)
            assert missions[moved].priority == missions[other].priority
