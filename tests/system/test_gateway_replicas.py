"""Two gateways on one ROS domain and one PostgreSQL, behind a plain reverse proxy: either can go at any time."""

import contextlib
import signal
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from tests.support.clients import HttpClient, connect
from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, Stream, running_dock_server, running_gateway
from tests.support.postgresql import binaries, running_postgresql
from tests.support.proxy import proxy
from tests.support.waiting import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed")]


@pytest.fixture(scope="module")
def database() -> Iterator[str]:
    with running_postgresql() as server:
        yield server.url


@pytest.fixture
def replicas(database: str) -> Iterator[tuple[RunningGateway, RunningGateway]]:
    with (
        ros_domain() as domain,
        running_dock_server(domain),
        running_gateway(domain, database_url=database) as first,
        running_gateway(domain, database_url=database) as second,
    ):
        first.wait_until_ready()
        second.wait_until_ready()
        first.wait_until_stored()
        second.wait_until_stored()
        yield first, second


def ids(events: list[dict[str, Any]]) -> list[str]:
    return [event["id"] for event in events if "id" in event]


def moments(events: list[dict[str, Any]], goal_id: str, *types: str) -> list[tuple[str, str]]:
    """The events of a goal by their type and time, which are the same at every gateway.

    Ids may differ by milliseconds, where messages of several topics overtook each other on their way to one of them.
    """
    return [
        (event["type"], event["time"]) for event in events if event.get("goal_id") == goal_id and event["type"] in types
    ]


def test_a_goal_sent_through_one_is_watched_and_canceled_through_the_other(
    replicas: tuple[RunningGateway, RunningGateway],
) -> None:
    first, second = replicas
    first.publish(LOW)
    with second.stream() as stream:
        sent = first.http.post("/dock", json={"desired_battery_state": CHARGING}).json()
        stream.until_type("feedback")
        seen = second.goal(sent["goal_id"])
        assert (seen["origin"], seen["goal"]) == ("gateway", sent["goal"])
        assert stream.once_seen(lambda event: event["type"] == "status")["origin"] == "gateway"
        assert second.http.post(f"/dock/{sent['goal_id']}/cancel").status_code == 202
        assert stream.until_type("result")["status"] == "canceled"
    assert first.wait_for_goal(sent["goal_id"], "canceled")["result"] is not None
    assert second.http.get("/dock").json()["goals"][0]["goal_id"] == sent["goal_id"]


def test_a_reader_that_loses_one_resumes_at_the_other(replicas: tuple[RunningGateway, RunningGateway]) -> None:
    first, second = replicas
    second.publish(LOW)
    with proxy(first.url, second.url) as front, second.stream() as witness:
        with HttpClient(front.url) as http:
            goal_id = http.post("/dock").raise_for_status().json()["goal_id"]
        with first.stream(f"?goal_id={goal_id}") as reader:
            for _ in range(10):
                reader.until_type("feedback")
            first.process.send_signal(signal.SIGKILL)
            with contextlib.suppress(ConnectionClosed):
                while True:
                    reader.next()
            before = reader.seen
        last = ids(before)[-1]
        time.sleep(1)
        address = f"{front.url.replace('http', 'ws')}/ws/feedback?goal_id={goal_id}&after={last}"
        with connect(address) as connection:
            again = Stream(connection)
            assert again.next()["type"] == "resumed"
            for _ in range(10):
                again.until_type("feedback")
            second.publish(CHARGING)
            assert again.until_type("result")["status"] == "succeeded"
        witness.until_type("result")
    together = before + again.seen
    assert [event for event, count in Counter(ids(together)).items() if count > 1] == []
    own, every = (moments(events, goal_id, "feedback", "result") for events in (together, witness.seen))
    # On a busy machine, the one that was the last before the kill may come again, a little later by its id.
    assert sum(count - 1 for count in Counter(own).values()) <= 1
    assert Counter(kind for kind, _ in own)["result"] == 1
    assert set(every[every.index(own[0]) :]) - set(own) == set()


def test_one_key_is_one_goal_through_both(replicas: tuple[RunningGateway, RunningGateway]) -> None:
    first, second = replicas
    first.publish(LOW)
    headers = {"Idempotency-Key": f"race-{time.time_ns()}"}

    def send(gateway: RunningGateway) -> tuple[int, str]:
        response = gateway.http.post("/dock", headers=headers)
        return response.status_code, response.json()["goal_id"]

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(send, [first, second] * 4))
    assert {status for status, _ in answers} == {202}
    assert len({goal_id for _, goal_id in answers}) == 1
    running = first.http.get("/dock", params={"status": "executing"}).json()["goals"]
    assert [goal["goal_id"] for goal in running] == [answers[0][1]]
    assert first.stop_once()["canceling"] == [answers[0][1]]


def test_each_event_is_stored_once(replicas: tuple[RunningGateway, RunningGateway]) -> None:
    first, second = replicas
    first.publish(LOW)
    with first.stream() as one, second.stream() as two:
        goal_id = first.http.post("/dock").json()["goal_id"]
        for _ in range(20):
            one.until_type("feedback")
        first.publish(CHARGING)
        for stream in (one, two):
            stream.until(lambda event: event["type"] == "result" and event["goal_id"] == goal_id)
    seen = [moments(stream.seen, goal_id, "feedback", "result") for stream in (one, two)]
    # The server sends the last feedback right before the result. A gateway that the result reaches first drops it.
    every = max(seen, key=len)
    assert all(each in (every, [*every[:-2], every[-1]]) for each in seen), seen

    def stored(gateway: RunningGateway) -> list[tuple[str, str]]:
        answer = gateway.http.get(f"/goals/{goal_id}/history?type=feedback&type=result").raise_for_status()
        return sorted(moments(answer.json()["events"], goal_id, "feedback", "result"))

    for gateway in replicas:
        wait_until(lambda gateway=gateway: stored(gateway) == sorted(every), "each event is stored once")
