"""The comparison that every test makes with the OpenAPI document finds differences (`tests/support/shapes.py`)."""

from typing import Any

import orjson
import pytest

from tests.support.shapes import check_answer, check_event, noted

STOP = {
    "latched": False,
    "for_all": False,
    "stopped_at": None,
    "by": None,
    "robots": [],
    "stops": [],
    "persisted": True,
}
PROBLEM = {"type": "about:blank", "title": "No", "status": 404, "code": "goal_not_found", "detail": "no such goal"}
HEARTBEAT = {"type": "heartbeat", "id": "1", "time": "2026-11-22T09:00:00Z"}
JSON, PROBLEM_JSON = "application/json", "application/problem+json"
GOAL_EVENTS = "/dock/7d9c1c9e-0000-4000-8000-000000000000/events"


def answer(path: str, status: int, kind: str, document: object, method: str = "GET") -> list[str]:
    check_answer(method, path, status, kind, b"" if document is None else orjson.dumps(document))
    return noted()


@pytest.mark.parametrize(
    ("method", "path", "status", "kind", "document"),
    [
        ("GET", "/stop", 200, JSON, STOP),
        ("GET", "/stop", 422, PROBLEM_JSON, PROBLEM | {"errors": []}),
        ("GET", "/stop", 403, PROBLEM_JSON, PROBLEM),
        ("PATCH", "/stop", 405, PROBLEM_JSON, PROBLEM),
        ("GET", "/nothing", 404, PROBLEM_JSON, PROBLEM),
        ("GET", "/goals/export", 200, JSON, []),
        ("GET", "/actions/robot1/fibonacci/goals", 200, JSON, {"goals": [], "next_cursor": None}),
        ("DELETE", "/battery/publisher", 204, "", None),
        ("GET", "/assets/index.js", 200, "text/javascript", None),
    ],
)
def test_a_documented_answer(method: str, path: str, status: int, kind: str, document: object) -> None:
    assert answer(path, status, kind, document, method) == []


@pytest.mark.parametrize(
    ("document", "difference"),
    [
        (STOP | {"extra": 1}, "'extra'"),
        ({name: value for name, value in STOP.items() if name != "by"}, "'by' is a required property"),
        (STOP | {"robots": [1]}, "$.robots[0]: 1 is not of type 'string'"),
        (STOP | {"stopped_at": "yesterday"}, "'yesterday'"),
    ],
)
def test_a_shape_that_differs(document: dict[str, Any], difference: str) -> None:
    (message,) = answer("/stop", 200, JSON, document)
    assert message.startswith("GET /stop → 200: ")
    assert difference in message


@pytest.mark.parametrize(
    ("path", "status", "kind", "document", "difference"),
    [
        ("/stop", 418, JSON, STOP, "the status is not documented"),
        ("/stop", 200, PROBLEM_JSON, STOP, "the media type is application/problem+json"),
        ("/stop", 422, PROBLEM_JSON, PROBLEM | {"hint": "?"}, "'hint'"),
        ("/nothing", 200, JSON, {}, "is a required property"),
    ],
)
def test_an_answer_that_is_not_documented(path: str, status: int, kind: str, document: object, difference: str) -> None:
    (message, *_) = answer(path, status, kind, document)
    assert difference in message


def event(path: str, document: object) -> list[str]:
    check_event(path, orjson.dumps(document))
    return noted()


def test_events_and_answers_of_a_stream() -> None:
    assert event("/ws/feedback?include=system", HEARTBEAT) == []
    assert event("/ws", {"op": "ack", "id": "1", "time": "2026-11-22T09:00:00Z"}) == []
    assert event("/ws", HEARTBEAT | {"subscription": "1"}) == []
    feedback = {**HEARTBEAT, "type": "feedback", "id": "1", "goal_id": "a", "action_name": "/fibonacci"}
    assert event(GOAL_EVENTS, feedback | {"feedback": {"partial_sequence": [0]}}) == []


@pytest.mark.parametrize(
    ("path", "document", "difference"),
    [
        ("/ws/feedback", HEARTBEAT | {"type": "surprise"}, "its type is 'surprise'"),
        ("/ws/feedback?include=system", HEARTBEAT | {"robot": "/"}, "/ws/feedback, a message of type heartbeat: $: "),
        ("/ws/topics?topic=/a", HEARTBEAT | {"type": "snapshot"}, "its type is 'snapshot'"),
        ("/ws", {"op": "ack", "id": "1"}, "/ws, a message: "),
        ("/ws", HEARTBEAT, "it does not say to which subscription it belongs"),
        (GOAL_EVENTS, HEARTBEAT | {"time": 1}, "$.time: 1 is not of type 'string'"),
    ],
)
def test_events_that_differ(path: str, document: dict[str, Any], difference: str) -> None:
    (message, *_) = event(path, document)
    assert difference in message


def test_a_difference_is_noted_once_and_then_forgotten() -> None:
    for _ in range(3):
        check_event("/ws/feedback", orjson.dumps(HEARTBEAT | {"robot": "/"}))
    assert len(noted()) == 1
    assert noted() == []
