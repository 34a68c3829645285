"""The steps of a mission as a program: a flat list, in which steps that have others come right before them.

`compile_steps` makes it of what clients send, and the other functions say where a mission goes on after a step: to the
next one, once more to the first one of a `repeat`, to the next one of `first_that_works`, or to a step by its name.
Plain data.
"""

from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime, timedelta
from itertools import count
from typing import Annotated, Any

from pydantic import Field

from dock_gateway.core.errors import FieldError, InvalidField, fields_of_a_message
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.step import Alternatives, FailurePolicy, GoTo, Repeat, StepFields
from dock_gateway.extensions.missions.step_entry import Reason, StepEntry, StepStatus
from dock_gateway.http.bodies import read_model
from dock_gateway.http.schema import Schema

# All steps of a mission, also those inside of others, and how deep they may be inside of each other.
MAX_STEPS = 200
MAX_DEPTH = 5
# Between the beginnings of two rounds of a `repeat`: what takes no time does not keep a gateway busy.
ROUND = timedelta(seconds=1)


class StepList(Schema):
    """The steps of a mission."""

    steps: Annotated[list[StepFields], Field(min_length=1, max_length=MAX_STEPS)]


# ---------------------------------------------------------------------- from what clients send


def compile_steps(steps: Sequence[StepFields]) -> tuple[StepEntry, ...]:
    """Return the program of some steps.

    Raises:
        InvalidField: There are too many, they are too deep inside of each other, a `repeat` would never end and take no
            time, or a step to go to is not a later one; with the path.
    """
    program = tuple(_flat(steps, "", 1))
    if len(program) > MAX_STEPS:
        raise _wrong("steps", f"at most {MAX_STEPS} steps", f"got {len(program)} with those inside of others")
    _require_names(program)
    for index, step in enumerate(program):
        inside = program[index + 1 : index + 1 + step.size]
        if step.repeat is not None and step.repeat.times is None and not any(each.takes_time for each in inside):
            path = f"steps.{step.path}.repeat"
            raise _wrong(path, "a wait or a goal in what is repeated for ever", "got none")
        parent = _parent(program, index)
        if step.on_failure is FailurePolicy.NEXT and parent is not None and program[parent].repeat is None:
            raise _wrong(
                f"steps.{step.path}.on_failure", "end, or a step to go to: the next one is taken anyway", "got next"
            )
        if isinstance(step.on_failure, GoTo):
            _require_target(program, index, step.on_failure.go_to)
    return program


def _flat(steps: Iterable[StepFields], prefix: str, depth: int) -> Iterator[StepEntry]:
    for number, step in enumerate(steps):
        path = f"{prefix}{number}"
        where, inside = step.inside
        if where and depth == MAX_DEPTH:
            raise _wrong(f"steps.{path}.{where}", f"at most {MAX_DEPTH} steps inside of each other", "got more")
        place = f"{path}.{where}."
        children = [*_flat(map(_read, inside, (f"steps.{place}{at}" for at in count())), place, depth + 1)]
        yield StepEntry(
            **step.common,
            path=path,
            size=len(children),
            repeat=None if step.repeat is None else Repeat(times=step.repeat.times, round=0),
            first_that_works=None if step.first_that_works is None else Alternatives(alternatives=len(inside)),
        )
        yield from children


def _read(fields: dict[str, Any], path: str) -> StepFields:
    """Return a step that is inside of another one; `path` is its own.

    Raises:
        InvalidField: It is none.
    """
    with fields_of_a_message(path):
        return read_model(StepFields, fields)


def _require_names(program: Sequence[StepEntry]) -> None:
    names: set[str] = set()
    for step in program:
        if step.name in names:
            raise _wrong(f"steps.{step.path}.name", "a name that no other step has", f"got {step.name!r}")
        names |= {step.name} if step.name is not None else set()


def _require_target(program: Sequence[StepEntry], index: int, name: str) -> None:
    """Refuse a step to go to that does not come later, in the same list or in one around it."""
    target = _named(program, name)
    lists = {None, *(at for at in _around(program, index) if program[at].repeat is not None)}
    if target is None or target < _behind(program, index) or _parent(program, target) not in lists:
        path = f"steps.{program[index].path}.on_failure.go_to"
        raise _wrong(path, "the name of a later step, not inside of another one", f"got {name!r}")


def _wrong(path: str, expected: str, got: str) -> InvalidField:
    return InvalidField([FieldError(path, expected, got)])


# ---------------------------------------------------------------------- where a mission is


def _parent(program: Sequence[StepEntry], index: int) -> int | None:
    """Return the index of the step that a step is inside of; None: of none."""
    return next((at for at in reversed(range(index)) if at + program[at].size >= index), None)


def _around(program: Sequence[StepEntry], index: int) -> Iterator[int]:
    """Return the indices of all steps that a step is inside of, the innermost first."""
    at = _parent(program, index)
    while at is not None:
        yield at
        at = _parent(program, at)


def _named(program: Sequence[StepEntry], name: str) -> int | None:
    return next((at for at, step in enumerate(program) if step.name == name), None)


def _behind(program: Sequence[StepEntry], index: int) -> int:
    return index + 1 + program[index].size


# ---------------------------------------------------------------------- where a mission goes on


def enter(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission at the first step that does something, of the one that it is at."""
    while mission.current.size:
        step = mission.current
        first = {} if step.repeat is None else {"repeat": step.repeat.model_copy(update={"round": 1})}
        mission = mission.with_step(status=StepStatus.RUNNING, started_at=now, finished_at=None, error=None, **first)
        mission = mission.but(step=mission.step + 1)
    return mission


def go_on(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission behind its present step, which has succeeded or does not matter."""
    return _after(_leave(mission), mission.step, StepStatus.SUCCEEDED, now)


def skip_step(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission without its present step: at the next alternative if it is one, else behind it."""
    index = mission.step
    mission = _leave(mission).with_step(status=StepStatus.SKIPPED, finished_at=now)
    mission = _skip(mission, range(index + 1, _behind(mission.steps, index)))
    other = _next_alternative(mission.steps, index)
    return _after(mission, index, StepStatus.SKIPPED, now) if other is None else _to(mission, other, now)


def fail_step(mission: MissionEntry, error: Reason, now: datetime) -> MissionEntry:
    """Return the mission after its present step has failed: where the step, or one around it, says."""
    index: int | None = mission.step
    mission = _leave(mission)
    while index is not None:
        mission = mission.with_step(index, status=StepStatus.FAILED, finished_at=now, error=error)
        mission = _skip(mission, range(index + 1, _behind(mission.steps, index)))
        policy, other = mission.steps[index].on_failure, _next_alternative(mission.steps, index)
        if isinstance(policy, GoTo):
            return _jump(mission, index, policy.go_to, now)
        if other is not None:
            return _to(mission, other, now)
        if policy is FailurePolicy.NEXT:
            return _after(mission, index, StepStatus.SUCCEEDED, now)
        index = _parent(mission.steps, index)
    return end(mission, MissionStatus.FAILED, now).model_copy(update={"error": error})


def end(mission: MissionEntry, status: MissionStatus, now: datetime) -> MissionEntry:
    """Return a mission that has ended, with the steps that it was inside of."""
    for index in _around(mission.steps, mission.step):
        if mission.steps[index].status is StepStatus.RUNNING:
            mission = mission.with_step(index, status=StepStatus.CANCELED, finished_at=now)
    return mission.but(status=status, held_for=None, pausing=False, wait_at=None, finished_at=now)


def _leave(mission: MissionEntry) -> MissionEntry:
    """Return the mission as it leaves its step: what people were told before that no longer stands."""
    return mission.but(notice=mission.notice and mission.notice.model_copy(update={"standing": False}))


def _next_alternative(program: Sequence[StepEntry], index: int) -> int | None:
    """Return the alternative that comes after a step; None: it is none, or the last one."""
    parent = _parent(program, index)
    if parent is None or program[parent].first_that_works is None:
        return None
    behind = _behind(program, index)
    return behind if behind < _behind(program, parent) else None


def _after(mission: MissionEntry, index: int, status: StepStatus, now: datetime) -> MissionEntry:
    """Return the mission behind a step; `status` is that of what it ends with the step."""
    program, behind, parent = mission.steps, _behind(mission.steps, index), _parent(mission.steps, index)
    if parent is None:
        if behind < len(program):
            return _to(mission, behind, now)
        return end(mission.but(step=behind), MissionStatus.SUCCEEDED, now)
    block, last = program[parent], _behind(program, parent)
    if block.repeat is None:
        mission = _skip(mission, range(behind, last))
    elif behind < last:
        return _to(mission, behind, now)
    elif block.repeat.times is None or block.repeat.round < block.repeat.times:
        return _again(mission, parent, now)
    else:
        status = StepStatus.SUCCEEDED
    return _after(mission.with_step(parent, status=status, finished_at=now), parent, status, now)


def _again(mission: MissionEntry, index: int, now: datetime) -> MissionEntry:
    """Return the mission at the next round of a `repeat`. Tries are counted on: no goal has the key of another."""
    block = mission.steps[index]
    if block.repeat is None or block.started_at is None:
        return mission
    begins = max(now, block.started_at + ROUND)
    repeat = block.repeat.model_copy(update={"round": block.repeat.round + 1})
    mission = mission.with_step(index, repeat=repeat, started_at=begins)
    for inside in range(index + 1, _behind(mission.steps, index)):
        new = StepEntry(**mission.steps[inside].asked, attempt=mission.steps[inside].attempt)
        mission = mission.with_step(inside, **dict(new))
    mission = _to(mission, index + 1, now)
    return mission.with_step(retry_at=begins) if begins > now else mission


def _jump(mission: MissionEntry, index: int, name: str, now: datetime) -> MissionEntry:
    """Return the mission at a later step. The steps that it leaves for that have failed, those between are skipped."""
    target = _named(mission.steps, name)
    if target is None:
        raise AssertionError(f"there is no step {name}")
    for left in _around(mission.steps, index):
        if target >= _behind(mission.steps, left):
            mission = mission.with_step(left, status=StepStatus.FAILED, finished_at=now)
    return _to(_skip(mission, range(_behind(mission.steps, index), target)), target, now)


def _to(mission: MissionEntry, index: int, now: datetime) -> MissionEntry:
    return enter(mission.but(step=index), now)


def _skip(mission: MissionEntry, indices: Sequence[int]) -> MissionEntry:
    for index in indices:
        if mission.steps[index].status is StepStatus.WAITING:
            mission = mission.with_step(index, status=StepStatus.SKIPPED)
    return mission
