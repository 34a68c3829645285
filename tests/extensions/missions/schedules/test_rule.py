"""What a schedule does at a time: each mission once, whatever the clock and the gateways do."""

from datetime import timedelta
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from dock_gateway.extensions.missions.schedules.rule import MAKE_UP, Run, Skip, decide, mission_id_of
from dock_gateway.extensions.missions.schedules.schedule import ScheduleOutcome
from tests.extensions.missions.examples import NOON
from tests.extensions.missions.schedules.examples import body, schedule

MINUTE = timedelta(minutes=1)
BERLIN = {"times": ["02:30", "13:00"], "time_zone": "Europe/Berlin"}  # 13:00 is NOON there


def test_a_time_is_due_from_then_on() -> None:
    hourly = schedule(NOON)
    assert decide("a", hourly, (), NOON + 59 * MINUTE) is None
    due = NOON + 60 * MINUTE
    assert decide("a", hourly, (), due) == Run(due, mission_id_of("a", due))
    assert decide("a", hourly.decided(ScheduleOutcome(due_at=due, decided_at=due)), (), due + MINUTE) is None
    assert decide("a", schedule(NOON, enabled=False), (), due) is None
    assert mission_id_of("a", due) != mission_id_of("b", due)


@pytest.mark.parametrize(("late", "made_up"), [(MAKE_UP, True), (MAKE_UP + MINUTE, False)])
def test_what_was_missed_is_made_up_once_if_it_is_not_too_long_ago(late: timedelta, made_up: bool) -> None:
    daily = schedule(NOON - 5 * MINUTE, daily=BERLIN)
    found = decide("a", daily, (), NOON + late)
    assert isinstance(found, Run if made_up else Skip)
    days = decide("a", daily, (), NOON + timedelta(days=3) + MINUTE)
    assert days == Run(NOON + timedelta(days=3), mission_id_of("a", NOON + timedelta(days=3)))


def test_one_that_is_stored_does_not_make_up_what_was_before() -> None:
    assert decide("a", schedule(NOON, daily=BERLIN), (), NOON) is None


def test_a_mission_that_has_not_ended() -> None:
    due = NOON + 60 * MINUTE
    skipped = decide("a", schedule(NOON), ["b"], due)
    assert isinstance(skipped, Skip)
    assert skipped.code == "still_running"
    assert isinstance(decide("a", schedule(NOON, if_running="queue"), ["b"], due), Run)
    own = mission_id_of("a", due)  # it was queued for this very time, and its gateway killed
    assert decide("a", schedule(NOON), [own], due + 5 * MINUTE) == Run(due, own)


TIMES = st.sampled_from(
    [
        {"every": {"minutes": 1}},
        {"every": {"minutes": 45}},
        {"daily": BERLIN},
        {"once": {"due_at": "2026-11-30T13:00:00Z"}},
    ]
)


class ScheduleMachine(RuleBasedStateMachine):
    """A schedule, gateways that are killed, a clock that jumps, and people who change it."""

    @initialize(times=TIMES, policy=st.sampled_from(["skip", "queue"]))
    def begin(self, times: dict[str, Any], policy: str) -> None:
        self.now = NOON
        self.fields = times | {"if_running": policy}
        self.stored = schedule(NOON, **self.fields)
        self.queued: list[str] = []
        self.open: set[str] = set()

    @rule(gateway=st.sampled_from(["lives", "killed first", "killed later"]))
    def look(self, gateway: str) -> None:
        found = decide("a", self.stored, self.open, self.now)
        if found is None or gateway == "killed first":
            return
        assert self.stored.enabled
        assert self.stored.after < found.due_at <= self.now
        outcome = ScheduleOutcome(due_at=found.due_at, decided_at=self.now)
        if isinstance(found, Run) and found.mission_id not in self.queued:  # else it is found by its id
            assert self.now - found.due_at <= MAKE_UP
            assert not self.open or self.stored.if_running == "queue"
            self.queued.append(found.mission_id)
            self.open.add(found.mission_id)
        if gateway == "lives":
            self.stored = self.stored.decided(outcome)

    @rule(seconds=st.one_of(st.integers(1, 200), st.integers(-200_000, 400_000)))
    def pass_time(self, seconds: int) -> None:
        self.now += timedelta(seconds=seconds)

    @rule()
    def end_missions(self) -> None:
        self.open.clear()

    @rule(enabled=st.booleans())
    def change(self, enabled: bool) -> None:
        self.stored = body(**self.fields, enabled=enabled).entry("/", self.now, self.stored.last)

    @invariant()
    def no_mission_is_queued_twice(self) -> None:
        assert len(self.queued) == len(set(self.queued))
        if self.stored.next_due is not None:
            assert self.stored.next_due > self.stored.after


TestSchedules = ScheduleMachine.TestCase
TestSchedules.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)
