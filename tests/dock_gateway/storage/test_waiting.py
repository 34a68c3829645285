"""What waits in memory: bounded, and what must be kept is never dropped."""

from datetime import UTC, datetime

from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage.rows import BATCH_EVENTS, Key
from dock_gateway.storage.waiting import WaitingEntries
from tests.support.history import make_event, make_goal


def test_feedback_beyond_the_limit_is_dropped_and_the_gap_remembered() -> None:
    waiting = WaitingEntries(10)
    for number in range(30):
        waiting.put_event(make_event(number, droppable=True))
        waiting.put_event(make_event(100 + number))
    assert list(waiting.droppable.values()) == [make_event(number, droppable=True) for number in range(20, 30)]
    assert len(waiting.events) == 30
    assert waiting.dropped == 20
    assert waiting.gaps == {"goals": make_event(19, droppable=True).id}


def test_what_must_be_kept_leaves_memory_only_for_the_spool() -> None:
    waiting = WaitingEntries(10)
    for number in range(30):
        waiting.put_event(make_event(number))
        waiting.put_goal(make_goal(number))
    assert waiting.evict() == 0
    waiting.saved(waiting.unspooled())
    assert waiting.unspooled() == {}
    assert waiting.evict() == 40
    assert (len(waiting.events), len(waiting.goals)) == (10, 10)


def test_a_goal_that_changes_while_it_is_written_goes_on_waiting() -> None:
    waiting = WaitingEntries(10)
    goal = make_goal(1, GoalStatus.PENDING)
    waiting.put_goal(goal)
    batch = waiting.batch()
    goal.status = GoalStatus.EXECUTING
    assert batch.goals[0].status is GoalStatus.PENDING
    waiting.put_goal(goal)
    waiting.done(batch)
    assert waiting.goals[goal.goal_id].status is GoalStatus.EXECUTING
    assert len(waiting.unspooled()) == 1
    waiting.done(waiting.batch())
    assert not waiting.anything
    assert waiting.unspooled() == {}


def test_a_key_is_forgotten_with_its_goal() -> None:
    waiting = WaitingEntries(10)
    waiting.put_key(Key("k", "g1", "f", datetime.now(UTC)))
    waiting.forget_key("k", "g2")
    assert len(waiting.unspooled()) == 1
    waiting.forget_key("k", "g1")
    waiting.forget_key("k", "g1")
    assert not waiting.anything
    assert waiting.unspooled() == {}


def test_batches_are_bounded() -> None:
    waiting = WaitingEntries(10_000)
    waiting.put_key(Key("k", "g1", "f", datetime.now(UTC)))
    waiting.put_key(Key("k", "g2", "f", datetime.now(UTC)))
    for number in range(BATCH_EVENTS + 1):
        waiting.put_event(make_event(number, droppable=number < 5))
    batch = waiting.batch()
    assert batch.full
    assert [key.goal_id for key in batch.keys] == ["g1"]
    assert len(batch.events) == BATCH_EVENTS
    waiting.done(batch)
    assert len(waiting.batch().events) == 1
    assert not waiting.batch().full


def test_what_nothing_takes_is_given_up_beyond_the_limit() -> None:
    waiting = WaitingEntries(10)
    for number in range(30):
        waiting.put_event(make_event(number))
        waiting.put_goal(make_goal(number, origin="external"))
        waiting.put_goal(make_goal(100 + number))
        waiting.put_goal(make_goal(200 + number, GoalStatus.EXECUTING, origin="external"))
    waiting.shed()
    assert list(waiting.events.values()) == [make_event(number) for number in range(20, 30)]
    assert waiting.gaps == {"goals": make_event(19).id}
    assert len(waiting.goals) == 10 + 30 + 30
    assert len(waiting.unspooled()) == 10 + 10 + 30 + 30
