"""Exports hold everything, however much it is, and are broken off where the rest cannot be had."""

import csv
import io
from collections.abc import AsyncGenerator
from types import SimpleNamespace
from typing import Any

import orjson
import pytest
from starlette.types import Message

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import feedback_event, result_event, status_event
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.goals import export_routes as exports
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.http.slow_clients import PacedResponse
from dock_gateway.storage import GoalFilter
from tests.support.history import START_NS, HistoryInMemory, make_goal
from tests.support.robot_actions import make_robot_actions


@pytest.fixture
def history() -> HistoryInMemory:
    return HistoryInMemory()


@pytest.fixture
def all_goals(history: HistoryInMemory) -> Goals:
    live: Any = SimpleNamespace(goal=lambda _: None)
    return Goals(live, make_robot_actions(), history)


async def whole(chunks: AsyncGenerator[bytes]) -> bytes:
    return b"".join([chunk async for chunk in chunks])


def table(data: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(data.decode(), newline="")))


@pytest.mark.parametrize("count", [0, 1, 200, 201, 1000])
async def test_all_goals_that_match(all_goals: Goals, history: HistoryInMemory, count: int) -> None:
    for number in range(count):
        history.record(make_goal(number, action="/robot1/dock"))
        history.record(make_goal(10_000 + number))
    expected = [f"goal-{number:04d}" for number in reversed(range(count))]
    wanted = GoalFilter(namespace="/robot1")
    data = await whole(exports.goals_as_csv(all_goals, history, wanted))
    assert data.startswith(b"goal_id,action_name,")
    assert [row["goal_id"] for row in table(data)] == expected
    goals = orjson.loads(await whole(exports.goals_as_json(all_goals, GoalDocuments(history), UNLIMITED, wanted)))
    assert [goal["goal_id"] for goal in goals] == expected
    assert all(goal["goal"] == {"order": 5} for goal in goals)


async def a_goal(history: HistoryInMemory, feedback: int) -> Goal:
    goal = make_goal(1, GoalStatus.EXECUTING)
    history.record_event(status_event(goal, START_NS))
    for number in range(feedback):
        goal.hear(b'{"sequence":%s}' % orjson.dumps(list(range(number % 7))), goal.created_at)
        history.record_event(feedback_event(goal, START_NS + 1 + number))
    goal.status = GoalStatus.SUCCEEDED
    history.record_event(result_event(goal, START_NS + 10_000))
    history.record(goal)
    return goal


@pytest.mark.parametrize("feedback", [0, 1, 499, 500, 1203])
async def test_all_events_of_a_goal(history: HistoryInMemory, feedback: int) -> None:
    goal = await a_goal(history, feedback)
    await history.notes.replace_tags(goal.goal_id, ["blocked"])
    (document,) = await GoalDocuments(history).full([goal], UNLIMITED)
    exported = orjson.loads(await whole(exports.goal_as_json(history, goal, document)))
    events = exported.pop("events")
    assert exported == orjson.loads(encode(goal.document())) | {"complete": True, "tags": ["blocked"], "notes": []}
    assert [event["type"] for event in events] == ["status", *["feedback"] * feedback, "result"]

    rows = table(await whole(exports.goal_as_csv(history, goal)))
    assert [row["id"] for row in rows] == [event["id"] for event in events if event["type"] == "feedback"]
    for row, event in zip(rows, events[1:-1], strict=True):
        sequence = [row[name] for name in row if name.startswith("sequence.")]
        assert [int(text) for text in sequence if text] == event["feedback"]["sequence"]


async def test_feedback_that_comes_during_an_export_is_left_out(history: HistoryInMemory) -> None:
    """Its columns are not known any more."""
    goal = await a_goal(history, 3)
    chunks = exports.goal_as_csv(history, goal)
    head = await anext(chunks)
    goal.hear(b'{"sequence":[1,2,3,4,5,6,7,8]}', goal.created_at)
    history.record_event(feedback_event(goal, START_NS + 20_000))
    assert len(table(head + await whole(chunks))) == 3


async def test_an_export_that_cannot_go_on_is_broken_off(caplog: pytest.LogCaptureFixture) -> None:
    async def chunks() -> AsyncGenerator[bytes]:
        yield b"2"
        raise Unavailable("the history database does not answer")

    sent: list[Message] = []

    async def send(message: Message) -> None:
        sent.append(message)

    async def receive() -> Any:
        raise AssertionError("nothing is read")

    answer = PacedResponse(b"1", chunks(), 1.0, media_type="text/csv", headers={})
    await answer({"type": "http", "asgi": {"spec_version": "2.4"}}, receive, send)
    assert [message.get("body") for message in sent] == [None, b"1", b"2"]
    assert all(message.get("more_body", True) for message in sent), "nobody may take it for the whole"
    assert "was aborted" in caplog.text
