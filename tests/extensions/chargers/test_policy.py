"""Who gets a dock, and when it is free again: single cases. The properties are in test_policy_properties.py."""

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from dock_gateway.extensions.chargers.dock import MAX_GOALS, DockBody, DockEntry, DockPose, DockRecord, Hold, WaitEntry
from dock_gateway.extensions.chargers.policy import (
    ARRIVES_WITHIN,
    ASKS_WITHIN,
    FREE,
    PATIENCE,
    SENT_WITHIN,
    Ask,
    GoalState,
    Obstacle,
    Seen,
    best,
    choices,
    follow,
    is_waiting,
    left,
    reserve,
    stand,
    waits_for,
)
from dock_gateway.http.schema import RobotSelection

NOON = datetime(2026, 11, 30, 12, tzinfo=UTC)
DOCK = DockBody().entry()
DOCKS = {"a": DOCK, "b": DOCK}
ASK = Ask("/robot1", ["a", "b"])
RESERVED = reserve(FREE, "/robot1", "goal", NOON)
STANDING = DockRecord(hold=Hold(robot="/robot1", standing=True, since_at=NOON))
OTHERS = DockRecord(hold=Hold(robot="/robot2", standing=True, since_at=NOON))


def after(seconds: float) -> datetime:
    return NOON + timedelta(seconds=seconds)


def choose(ask: Ask, *facts: Any, **more: Any) -> tuple[str | None, dict[str, Obstacle]]:
    """What a robot gets that nobody has measured the way of, and why if it gets nothing."""
    free, obstacles = choices(ask, *facts, **more)
    return (best(ask, free, facts[1], {}), {}) if free else (None, obstacles)


def seen(state: GoalState | None = None, **more: Any) -> Seen:
    return Seen({} if state is None else {"goal": state}, **more)


def wait(*docks: str, since: float = 0.0, asked: float = 0.0, battery: float | None = None) -> WaitEntry:
    return WaitEntry(docks=docks, since_at=after(since), asked_at=after(asked), battery=battery)


@pytest.mark.parametrize(
    ("records", "chosen", "obstacles"),
    [
        ({}, "a", {}),
        ({"a": OTHERS}, "b", {}),
        ({"a": OTHERS, "b": OTHERS}, None, {"a": Obstacle.OCCUPIED, "b": Obstacle.OCCUPIED}),
        ({"a": STANDING}, "a", {}),
        ({"a": DockRecord(out_of_order_at=NOON)}, "b", {}),
        ({"a": DockRecord(hold=Hold(robot=None, standing=True, since_at=NOON)), "b": OTHERS}, None, None),
    ],
)
def test_the_first_free_dock_is_chosen(
    records: dict[str, DockRecord], chosen: str | None, obstacles: dict[str, Obstacle] | None
) -> None:
    found = choose(ASK, DOCKS, records, {}, NOON)
    assert found[0] == chosen
    assert obstacles is None or found[1] == obstacles


def test_a_dock_that_is_not_shared_is_free_and_one_for_others_is_not() -> None:
    others = DockEntry(
        robots=RobotSelection(names=("/robot2",), groups=("hall",)), pose=None, changed_by=None, changed_at=NOON
    )
    assert choose(Ask("/robot1", ["x"]), DOCKS, {}, {}, NOON) == ("x", {})
    assert choose(Ask("/robot1", ["a"]), {"a": others}, {}, {}, NOON) == (None, {"a": Obstacle.UNFIT})
    assert choose(Ask("/robot1", ["a"], ("hall",)), {"a": others}, {}, {}, NOON) == ("a", {})


def test_the_nearest_dock_is_the_best_unless_the_robot_has_another_one() -> None:
    free = ["a", "b", "c"]
    assert best(ASK, free, {}, {}) == "a", "the first, where no distance is known"
    assert best(ASK, free, {}, {"b": 2.0, "c": 1.0}) == "c"
    assert best(ASK, free, {"a": STANDING}, {"a": 9.0, "c": 1.0}) == "a", "it has it already"
    assert best(Ask("/robot2", free), free, {"a": STANDING}, {"c": 1.0}) == "c"


def test_who_has_waited_longest_comes_first_and_who_asks_no_more_does_not_wait() -> None:
    waits = {"/robot2": wait("a", since=-10), "/robot3": wait("a", since=-5)}
    alone = Ask("/robot1", ["a"])
    assert choose(alone, DOCKS, {}, waits, NOON) == (None, {"a": Obstacle.QUEUE})
    assert choose(Ask("/robot3", ["a"]), DOCKS, {}, waits, NOON)[0] is None
    assert choose(Ask("/robot2", ["a"]), DOCKS, {}, waits, NOON)[0] == "a"
    assert choose(ASK, DOCKS, {}, waits, NOON)[0] == "b", "nobody waits for the other one"
    assert choose(alone, DOCKS, {}, waits, NOON + ASKS_WITHIN)[0] == "a"
    assert choose(alone, DOCKS, {"a": STANDING}, waits, NOON)[0] == "a", "it has it already"


def test_the_lowest_charge_comes_first_but_for_who_has_waited_very_long() -> None:
    waits = {
        "/robot1": wait("a", since=-10, battery=0.5),
        "/robot2": wait("a", since=-5, battery=0.1),
        "/robot3": wait("a", since=-20),
    }

    def first(known: dict[str, WaitEntry]) -> list[str]:
        chosen = (choose(Ask(robot, ["a"]), DOCKS, {}, known, NOON, by_charge=True)[0] for robot in sorted(known))
        return [robot for robot, dock in zip(sorted(known), chosen, strict=True) if dock is not None]

    assert first(waits) == ["/robot2"]
    patient = wait("a", since=-PATIENCE.total_seconds(), battery=0.9)
    assert first(waits | {"/robot1": patient}) == ["/robot1"]


@pytest.mark.parametrize(
    ("state", "more", "standing"),
    [
        (GoalState.RUNS, {}, False),
        (GoalState.LOST, {}, False),
        (GoalState.LOST, {"away": True}, False),
        (GoalState.SUCCEEDED, {}, True),
        (GoalState.ABORTED, {}, None),
        (GoalState.ABORTED, {"docked": True}, True),
        (GoalState.ENDED, {}, None),
        (None, {}, False),
    ],
)
def test_what_becomes_of_a_reservation(state: GoalState | None, more: dict[str, bool], standing: bool | None) -> None:
    hold = follow(RESERVED, seen(state, **more), after(5)).hold
    assert (None if hold is None else hold.standing) is standing
    if standing:
        assert hold is not None
        assert (hold.since_at, hold.goal_ids) == (after(5), ())


def test_a_goal_that_is_not_stored_yet_keeps_its_dock_a_minute() -> None:
    late = SENT_WITHIN.total_seconds()
    assert follow(RESERVED, seen(GoalState.MISSING), after(late - 1)) == RESERVED
    assert follow(RESERVED, seen(GoalState.MISSING), after(late)).hold is None
    again = reserve(RESERVED, "/robot1", "later", after(late))
    both = Seen({"goal": GoalState.ENDED, "later": GoalState.MISSING})
    hold = follow(again, both, after(late + 1)).hold
    assert hold is not None
    assert hold.goal_ids == ("later",), "the minute begins with the last goal"


def test_a_refused_second_goal_does_not_free_the_dock_of_the_first() -> None:
    record = reserve(RESERVED, "/robot1", "refused", after(1))
    states = Seen({"goal": GoalState.RUNS, "refused": GoalState.ENDED})
    hold = follow(record, states, after(2)).hold
    assert hold is not None
    assert hold.goal_ids == ("goal",)


@pytest.mark.parametrize(("more", "free"), [({}, False), ({"away": True}, True), ({"elsewhere": True}, True)])
def test_when_a_robot_has_left(more: dict[str, bool], free: bool) -> None:
    assert (follow(STANDING, seen(**more), after(5)).hold is None) is free
    again = reserve(STANDING, "/robot1", "goal", NOON)
    assert follow(again, seen(GoalState.RUNS, **more), after(5)).hold is not None, "it is on its way back"


def test_a_robot_that_returns_to_a_dock_that_it_left_unseen_stands_there_since_it_returned() -> None:
    """By which it is seen that it has left another dock at which it stood meanwhile."""
    again = reserve(STANDING, "/robot1", "goal", after(60))
    hold = follow(again, seen(GoalState.SUCCEEDED), after(90)).hold
    assert hold is not None
    assert hold.since_at == after(90)


def test_a_dock_is_out_of_order_after_failures_in_a_row() -> None:
    record = FREE
    for number in range(1, 4):
        assert record.out_of_order_at is None
        record = follow(reserve(record, "/robot1", "goal", NOON), seen(GoalState.ABORTED), after(number), 3)
    assert (record.failures, record.out_of_order_at) == (3, after(3))
    assert record.note == "3 dockings in a row have failed"
    fine = follow(reserve(FREE.model_copy(update={"failures": 2}), "/r", "goal", NOON), seen(GoalState.SUCCEEDED), NOON)
    assert fine.failures == 0
    never = follow(RESERVED.model_copy(update={"failures": 99}), seen(GoalState.ABORTED), NOON, 0)
    assert (never.failures, never.out_of_order_at) == (100, None)


def test_what_a_person_says() -> None:
    assert left(STANDING, [], NOON) == DockRecord(cleared_at=NOON)
    assert left(RESERVED, ["goal"], NOON) is None, "a robot comes"
    unknown = stand(FREE, None, "Ada", NOON)
    assert choose(Ask("/robot1", ["a"]), DOCKS, {"a": unknown}, {}, NOON) == (None, {"a": Obstacle.OCCUPIED})
    assert follow(unknown, seen(away=True), NOON) == unknown
    mine = stand(RESERVED, "/robot1", "Ada", NOON).hold
    assert mine is not None
    assert (mine.robot, mine.goal_ids, mine.standing, mine.by) == ("/robot1", ("goal",), True, "Ada")
    arrived = follow(DockRecord(hold=mine), seen(GoalState.SUCCEEDED), after(5)).hold
    assert arrived is not None
    assert (arrived.since_at, arrived.by) == (after(5), None), "it has been seen since"


def test_there_is_a_limit_of_goals() -> None:
    record = FREE
    for number in range(MAX_GOALS):
        record = reserve(record, "/robot1", str(number), NOON)
    assert choose(Ask("/robot1", ["a"]), DOCKS, {"a": record}, {}, NOON) == (None, {"a": Obstacle.TOO_MANY})


BAYS = [DockPose(x=float(x), y=0.0) for x in (1, 2, 3)]
WITH_BAYS = {
    "a": DockBody(waiting_places=[*BAYS[:2]]).entry(),
    "b": DockBody(waiting_places=[*BAYS[2:]]).entry(),
}


def test_each_robot_that_waits_has_a_place_of_its_own_and_keeps_it() -> None:
    known: dict[str, WaitEntry] = {}
    robots = [f"/robot{number}" for number in range(1, 6)]
    for robot in robots:
        known[robot] = waits_for(Ask(robot, ["b", "a"]), WITH_BAYS, known, NOON)
    assert [known[robot].wait_at for robot in robots] == [BAYS[2], BAYS[0], BAYS[1], None, None]
    del known["/robot1"]  # it has got a dock
    later = after(20)
    kept = waits_for(Ask("/robot2", ["b", "a"]), WITH_BAYS, known, later)
    assert (kept.wait_at, kept.since_at, kept.arrives_by) == (BAYS[0], NOON, None)
    moved = waits_for(Ask("/robot4", ["b", "a"]), WITH_BAYS, known, later)
    assert (moved.wait_at, moved.since_at, moved.arrives_by) == (BAYS[2], NOON, later + ARRIVES_WITHIN)


def test_a_robot_that_does_not_drive_takes_no_place() -> None:
    stays = waits_for(Ask("/robot1", ["a"], drives=False), WITH_BAYS, {}, NOON)
    assert (stays.wait_at, stays.arrives_by) == (None, None)
    drives = waits_for(Ask("/robot1", ["a"]), WITH_BAYS, {"/robot1": stays}, after(5))
    assert (drives.wait_at, drives.since_at, drives.arrives_by) == (BAYS[0], NOON, after(5) + ARRIVES_WITHIN)


def test_a_robot_that_drives_to_where_it_waits_need_not_ask() -> None:
    drives = waits_for(ASK, WITH_BAYS, {}, NOON)
    assert is_waiting(drives, after(299))
    assert not is_waiting(drives, NOON + ARRIVES_WITHIN)
    asks = waits_for(ASK, WITH_BAYS, {"/robot1": drives}, after(100))
    assert is_waiting(asks, after(129))
    assert not is_waiting(asks, after(130))
    assert not is_waiting(drives, after(-31))  # the clock was set back


def test_a_place_that_is_no_longer_listed_is_left() -> None:
    before = waits_for(ASK, WITH_BAYS, {}, NOON)
    assert before.wait_at == BAYS[0]
    without = {"a": DockBody(waiting_places=[BAYS[1]]).entry(), "b": DOCK}
    assert waits_for(ASK, without, {"/robot1": before}, NOON).wait_at == BAYS[1]
    assert waits_for(ASK, DOCKS, {"/robot1": before}, NOON).wait_at is None
