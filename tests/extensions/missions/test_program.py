"""Where a mission goes on: as an interpreter of nested steps would, with whatever succeeds and fails."""

from collections.abc import Iterator
from datetime import timedelta
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.core.errors import InvalidField
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Change, Facts, Wait, WaitsFor
from dock_gateway.extensions.missions.progress import next_move
from dock_gateway.extensions.missions.step_entry import Reason, StepStatus
from tests.extensions.missions.examples import DOCK, NOON, UNDOCK, after, begun, queued

FAILURE = Reason(code="no", detail="as the test says")
WAIT: dict[str, Any] = {"wait": {"seconds": 1}}
# Leaves that are taken before a run is long enough.
MANY = 40

Step = dict[str, Any]


@st.composite
def some_steps(draw: st.DrawFn, prefix: str = "", depth: int = 3, targets: tuple[str, ...] = ()) -> list[Step]:
    """Steps inside of each other, each with its path as its name; `targets` are those that they may go to."""
    names = [f"{prefix}{number}" for number in range(draw(st.integers(1, 3)))]
    return [
        draw(a_step(name, depth, (*names[number + 1 :], *targets), policies=("end", "next")))
        for number, name in enumerate(names)
    ]


@st.composite
def a_step(draw: st.DrawFn, name: str, depth: int, targets: tuple[str, ...], policies: tuple[str, ...]) -> Step:
    kind = draw(st.sampled_from(["wait", "repeat", "first"] if depth else ["wait"]))
    policy: Any = draw(st.sampled_from([*policies, *({"go_to": target} for target in targets)]))
    step: Step = {"name": name, "on_failure": policy}
    if kind == "wait":
        return step | WAIT
    if kind == "repeat":
        times = draw(st.sampled_from([None, 1, 2, 3]))
        return step | {
            "repeat": {"times": times, "steps": draw(some_steps(f"{name}.repeat.steps.", depth - 1, targets))}
        }
    alternatives = [
        draw(a_step(f"{name}.first_that_works.{number}", depth - 1, targets, policies=("end",)))
        for number in range(draw(st.integers(1, 3)))
    ]
    return step | {"first_that_works": alternatives}


class LongEnough(Exception):
    """There are no more outcomes."""


class Interpreter:
    """Takes nested steps one after the other; a result is `ok`, `failed` or the name of the step to go to."""

    def __init__(self, outcomes: list[bool]) -> None:
        self.outcomes = iter(outcomes)
        self.taken: list[str] = []

    def run(self, steps: list[Step]) -> str:
        index = 0
        while index < len(steps):
            result = self.take(steps[index])
            names = [step["name"] for step in steps]
            if result != "ok" and result not in names:
                return result
            index = index + 1 if result == "ok" else names.index(result)
        return "ok"

    def take(self, step: Step) -> str:
        result = self.try_once(step)
        if result != "failed" or step["on_failure"] == "end":
            return result
        return "ok" if step["on_failure"] == "next" else str(step["on_failure"]["go_to"])

    def try_once(self, step: Step) -> str:
        if "repeat" in step:
            rounds = step["repeat"]["times"]
            while rounds is None or rounds > 0:
                result = self.run(step["repeat"]["steps"])
                if result != "ok":
                    return result
                rounds = rounds and rounds - 1
            return "ok"
        if "first_that_works" in step:
            for each in step["first_that_works"]:
                result = self.take(each)
                if result != "failed":
                    return result
            return "failed"
        outcome = next(self.outcomes, None)
        if outcome is None:
            raise LongEnough
        self.taken.append(step["name"])
        return "ok" if outcome else "failed"


def taken(mission: MissionEntry, outcomes: list[bool]) -> Iterator[tuple[str, MissionEntry]]:
    """Take the steps of a mission; yield the path of each with the mission after it."""
    now = NOON
    for outcome in outcomes:
        if mission.status.ended:
            return
        path, attempt = mission.current.path, mission.current.attempt
        mission = mission.with_step(status=StepStatus.RUNNING, attempt=attempt + 1, started_at=now)
        now += timedelta(seconds=5)
        mission = progress.succeed(mission, now) if outcome else progress.fail(mission, FAILURE, now)
        yield path, mission


@settings(max_examples=300, deadline=None)
@given(some_steps(), st.lists(st.booleans(), min_size=MANY, max_size=MANY))
def test_a_mission_takes_the_steps_that_an_interpreter_takes(steps: list[Step], outcomes: list[bool]) -> None:
    interpreter = Interpreter(outcomes)
    try:
        result = interpreter.run(steps)
    except LongEnough:
        result = ""
    found = [*taken(begun(*steps), outcomes)]
    assert [path for path, _ in found] == interpreter.taken
    last = found[-1][1]
    expected = {"ok": MissionStatus.SUCCEEDED, "failed": MissionStatus.FAILED, "": MissionStatus.RUNNING}
    assert last.status is expected[result]
    running = [step for step in last.steps if step.status is StepStatus.RUNNING]
    around = [step for step in last.steps if step.size and last.steps.index(step) < last.step]
    if last.status.ended:
        assert running == []
    else:  # those that the mission is inside of, and no others
        assert running == [each for each in around if last.steps.index(each) + each.size >= last.step]
    if last.status is MissionStatus.SUCCEEDED:
        assert StepStatus.WAITING not in {step.status for step in last.steps}


@settings(max_examples=100, deadline=None)
@given(some_steps(), st.lists(st.booleans(), min_size=MANY, max_size=MANY))
def test_no_two_goals_have_the_same_key(steps: list[Step], outcomes: list[bool]) -> None:
    mission, keys = begun(*steps), []
    for _, later in taken(mission, outcomes):
        at = mission.step
        assert later.steps[at].attempt == mission.steps[at].attempt + 1
        keys.append((at, later.steps[at].attempt))
        mission = later
    assert len(keys) == len({*keys})


def repeat(*steps: Step, times: int | None = None, **fields: Any) -> Step:
    return {"repeat": {"steps": [*steps], "times": times}, **fields}


def test_rounds_are_a_second_apart() -> None:
    mission = begun(repeat({"wait": {"seconds": 0}}, times=2), DOCK)
    block = mission.steps[0]
    assert (mission.step, block.status, block.repeat and block.repeat.round, block.started_at) == (
        1,
        "running",
        1,
        NOON,
    )
    again = progress.succeed(mission, after(0.25))
    assert (again.step, again.steps[0].repeat and again.steps[0].repeat.round) == (1, 2)
    assert next_move(again, Facts(), after(0.5)) == Wait(WaitsFor.TIME, after(1))
    late = progress.succeed(mission, after(7))
    assert (late.current.retry_at, late.steps[0].started_at) == (None, after(7))
    done = progress.succeed(late, after(8))
    assert (done.step, done.steps[0].status, done.steps[0].finished_at) == (2, StepStatus.SUCCEEDED, after(8))


def test_of_alternatives_the_next_one_is_taken_if_one_fails_or_is_skipped() -> None:
    first = begun({"first_that_works": [DOCK, UNDOCK, WAIT]}, DOCK)
    assert first.step == 1
    second = progress.fail(first, FAILURE, after(1))
    assert (second.step, second.steps[1].error) == (2, FAILURE)
    held = second.but(status=MissionStatus.HELD, held_for="stop")
    third = progress.skip(held, after(2))
    assert (third.step, third.steps[2].status, third.status) == (3, StepStatus.SKIPPED, MissionStatus.RUNNING)
    behind = progress.skip(third.but(status=MissionStatus.HELD, held_for="stop"), after(3))
    assert (behind.step, behind.steps[0].status) == (4, StepStatus.SKIPPED)
    worked = progress.succeed(second, after(3))
    assert [step.status for step in worked.steps] == ["succeeded", "failed", "succeeded", "skipped", "waiting"]
    assert worked.step == 4


def test_a_step_that_is_skipped_before_a_mission_begins_takes_those_inside_of_it_along() -> None:
    paused = progress.pause(queued({"repeat": {"steps": [DOCK, WAIT], "times": 2}}, UNDOCK))
    started = progress.start(progress.skip(paused, after(1)), after(2))
    assert started.step == 3
    assert [step.status for step in started.steps] == ["skipped", "skipped", "skipped", "waiting"]


def test_a_failure_goes_to_a_step_by_its_name() -> None:
    home = UNDOCK | {"name": "home"}
    mission = begun(repeat(DOCK | {"on_failure": {"go_to": "home"}}, WAIT), WAIT, home)
    home_at = progress.fail(mission, FAILURE, after(1))
    assert home_at.current.name == "home"
    assert [step.status for step in home_at.steps] == ["failed", "failed", "skipped", "skipped", "waiting"]


def test_a_mission_that_is_canceled_inside_of_others() -> None:
    mission = progress.cancel(begun(repeat(repeat(WAIT, times=2))), after(1))
    ended = next_move(mission, Facts(), after(1))
    assert isinstance(ended, Change)
    assert [step.status for step in ended.mission.steps] == 3 * ["canceled"]


@pytest.mark.parametrize(
    ("steps", "path"),
    [
        ([repeat({"notify": {"text": "Hello"}})], "steps.0.repeat"),
        (
            [WAIT, repeat(repeat(DOCK, times=2), repeat({"publish": {"topic": "/light"}}))],
            "steps.1.repeat.steps.1.repeat",
        ),
        ([repeat(*(100 * [WAIT])), repeat(*(99 * [WAIT]))], "steps"),
        ([repeat(repeat(repeat(repeat(repeat(WAIT)))))], "steps.0" + 4 * ".repeat.steps.0" + ".repeat.steps"),
        ([WAIT | {"name": "a"}, repeat(WAIT | {"name": "a"})], "steps.1.repeat.steps.0.name"),
        ([repeat(WAIT, {"fly": {}})], "steps.0.repeat.steps.1.fly"),
        ([repeat({})], "steps.0.repeat.steps.0"),
        ([repeat(repeat({"wait": {"seconds": -1}}))], "steps.0.repeat.steps.0.repeat.steps.0.wait.seconds"),
        ([{"first_that_works": [WAIT, WAIT | {"on_failure": "next"}]}], "steps.0.first_that_works.1.on_failure"),
        ([WAIT | {"on_failure": {"go_to": "a"}}], "steps.0.on_failure.go_to"),
        ([WAIT | {"name": "a", "on_failure": {"go_to": "a"}}], "steps.0.on_failure.go_to"),
        ([WAIT | {"name": "a"}, DOCK | {"on_failure": {"go_to": "a"}}], "steps.1.on_failure.go_to"),
        ([WAIT | {"on_failure": {"go_to": "a"}}, repeat(WAIT | {"name": "a"})], "steps.0.on_failure.go_to"),
        ([repeat(WAIT | {"name": "a"}, on_failure={"go_to": "a"})], "steps.0.on_failure.go_to"),
        (
            [{"first_that_works": [WAIT | {"on_failure": {"go_to": "a"}}, WAIT | {"name": "a"}]}],
            "steps.0.first_that_works.0.on_failure.go_to",
        ),
    ],
)
def test_what_is_no_program(steps: list[Step], path: str) -> None:
    with pytest.raises(InvalidField) as refused:
        queued(*steps)
    assert [error.path for error in refused.value.errors] == [path]


def test_what_is_one() -> None:
    for steps in (
        [repeat(*(100 * [WAIT])), repeat(*(98 * [WAIT]))],
        [repeat(repeat(repeat(repeat(WAIT))))],
        [repeat({"first_that_works": [{"call": {"service": "/reset"}}, DOCK]})],
        [repeat({"notify": {"text": "Hello"}}, times=2)],
    ):
        mission = queued(*steps)
        assert [step.path.count(".") == 0 for step in mission.steps].count(True) == len(steps)
