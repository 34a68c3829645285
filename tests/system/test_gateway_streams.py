"""Streams that resume, thin out, and speak SSE as well: real gateway, server and DDS."""

import time
from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.clients import server_sent_events
from tests.support.domain import ros_domain
from tests.support.gateway import (
    ACTION,
    CHARGING,
    LOW,
    RunningGateway,
    ready_gateway,
)
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

GONE = "00000000000000000001-f00000000"


@pytest.fixture(scope="module")
def gateway() -> Iterator[RunningGateway]:
    with ros_domain() as domain, ready_gateway(domain) as gateway:
        yield gateway


@pytest.fixture
def running(gateway: RunningGateway) -> Iterator[str]:
    gateway.publish(LOW)
    goal_id: str = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
    yield goal_id
    gateway.stop_once()
    gateway.wait_for_goal(goal_id, "canceled", "succeeded")


def ids(events: list[dict[str, Any]]) -> list[str]:
    return [event["id"] for event in events if "id" in event]


def test_a_reader_that_was_away_gets_what_it_missed_and_nothing_twice(gateway: RunningGateway, running: str) -> None:
    with gateway.stream(f"?goal_id={running}") as witness, gateway.stream(f"?goal_id={running}") as first:
        for _ in range(5):
            last = first.until_type("feedback")["id"]
        first.connection.close()
        if last not in ids(witness.seen):
            witness.until(lambda event: event.get("id") == last)
        for _ in range(5):
            witness.until_type("feedback")
        with gateway.stream(f"?goal_id={running}&after={last}") as second:
            resumed = second.next()
            assert resumed["type"] == "resumed"
            assert resumed["count"] >= 5
            for _ in range(20):
                second.until_type("feedback")
            newest = second.seen[-1]["id"]
        if newest not in ids(witness.seen):
            witness.until(lambda event: event.get("id") == newest)
        seen = ids(witness.seen)
        expected = seen[seen.index(last) + 1 : seen.index(newest) + 1]
        assert ids(second.seen) == expected


def test_what_is_not_replayed_is_told_as_it_is_now(gateway: RunningGateway, running: str) -> None:
    with gateway.stream("?include=system,fleet") as first:
        last = first.until_type("feedback")["id"]
    gateway.http.post("/stop", json={"by": "Ada"}).raise_for_status()
    gateway.http.delete("/battery/publisher").raise_for_status()
    gateway.wait_for_goal(running, "canceled")
    with gateway.stream(f"?include=system,fleet&after={last}") as second:
        missed = second.next()["count"]
        for _ in range(missed):
            assert "id" in second.next()
        present = [second.next() for _ in range(8)]
    gateway.http.delete("/stop").raise_for_status()
    gateway.publish(LOW)
    types = ["stop", "battery_publisher", "docking", "robots", "alerts", "approvals", *["action_server"] * 2]
    assert [event["type"] for event in present] == types
    stop, publisher, docking, robots, _, _, dock, undock = present
    assert (stop["robot"], stop["stop"]["latched"], stop["stop"]["by"]) == ("/", True, "Ada")
    assert publisher["battery_publisher"]["active"] is False
    assert docking["docking"]["dock"]["action_name"] == ACTION
    server = dock["action_server"]
    assert (server["action_name"], server["available"], server["duplicate"]) == (ACTION, True, False)
    assert undock["action_server"]["available"] is False
    assert robots["robots"][0]["stop"]["by"] == "Ada"
    with gateway.stream(f"?after={last}") as third:  # who did not ask for it is not told
        for _ in range(third.next()["count"]):
            third.next()
        gateway.publish(LOW)
        assert third.next()["type"] == "heartbeat"


def test_a_past_that_is_gone_is_said_to_be(gateway: RunningGateway, running: str) -> None:
    with gateway.stream(f"?after={GONE}") as stream:
        gap = stream.next()
        assert (gap["type"], gap["after"]) == ("gap", GONE)
        stored = [stream.next() for _ in range(gap["count"])]
        assert running in {event["goal_id"] for event in stored}
        assert stored == sorted(stored, key=lambda event: event["id"])
        assert stream.next()["type"] == "snapshot"
        stream.until_type("feedback")


def test_max_rate_thins_feedback_out_and_leaves_the_end_alone(gateway: RunningGateway, running: str) -> None:
    with gateway.stream(f"?goal_id={running}&max_rate=2") as slow, gateway.stream(f"?goal_id={running}") as fast:
        until = time.monotonic() + 3
        while time.monotonic() < until:
            fast.until_type("feedback")
        gateway.publish(CHARGING)
        assert fast.until_type("result")["status"] == "succeeded"
        assert slow.until_type("result")["status"] == "succeeded"
    counts = [sum(event["type"] == "feedback" for event in stream.seen) for stream in (slow, fast)]
    assert counts[0] <= 10
    assert counts[1] >= 20


def test_server_sent_events_until_the_end(gateway: RunningGateway, running: str) -> None:
    with gateway.http.stream("GET", f"/dock/{running}/events") as response:
        assert response.headers["content-type"].startswith("text/event-stream")
        events = server_sent_events(response)
        _, snapshot = next(events)
        assert snapshot["type"] == "snapshot"
        assert [goal["goal_id"] for goal in snapshot["goals"]] == [running]
        identity, feedback = next((i, e) for i, e in events if e["type"] == "feedback")
        assert identity == feedback["id"]
        gateway.publish(CHARGING)
        rest = [event for _, event in events]  # it ends by itself
        assert rest[-1]["type"] == "result"
    with gateway.http.stream("GET", f"/dock/{running}/events", headers={"Last-Event-ID": identity}) as response:
        again = [event for _, event in server_sent_events(response)]
    assert again[0]["type"] == "resumed"
    assert ids(again) == ids(rest)
    with gateway.http.stream(
        "GET", f"/dock/{running}/events", params={"feedback": "false", "after": identity}
    ) as response:
        types = [
            event["type"] for _, event in server_sent_events(response)
        ]  # on a busy machine the goal may seem stalled meanwhile
        assert (types[0], types[-1], set(types[1:-1])) == ("resumed", "result", {"status"})
    with gateway.http.stream("GET", f"/dock/{running}/events") as response:
        (only,) = [event for _, event in server_sent_events(response)]
    assert only["goals"][0]["status"] == "succeeded"
    # An `EventSource` connects again, with the id of what it has seen last, until there is an answer without content.
    for seen in (rest[-1], only):
        over = gateway.http.get(f"/goals/{running}/events", headers={"Last-Event-ID": seen["id"]})
        assert (over.status_code, over.content) == (204, b"")


def test_server_sent_events_of_nothing(gateway: RunningGateway) -> None:
    unknown = gateway.http.get("/dock/7d9c1c9e-0000-4000-8000-000000000000/events")
    assert (unknown.status_code, unknown.json()["code"]) == (404, "goal_not_found")
    wrong = gateway.http.get("/dock/7d9c1c9e-0000-4000-8000-000000000000/events", headers={"Last-Event-ID": "x"})
    assert wrong.status_code == 422
    assert [(error["in"], error["path"]) for error in wrong.json()["errors"]] == [("header", "Last-Event-ID")]


def test_readers_that_leave_are_forgotten(gateway: RunningGateway, running: str) -> None:
    for _ in range(5):
        with gateway.http.stream("GET", f"/dock/{running}/events") as response:
            next(server_sent_events(response))
        with gateway.stream(f"?goal_id={running}") as stream:
            stream.next()
    wait_until(lambda: not gateway.http.get("/healthz").json()["subscribers"], "every reader has left")
