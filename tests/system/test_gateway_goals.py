"""`/goals`: the goals of every action, the gateway's own and those of others, also of actions that have gone."""

import csv
import io
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support.gateway import RunningGateway, running_program
from tests.support.processes import client_process
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@contextmanager
def fibonacci(domain: int, gateway: RunningGateway, namespace: str) -> Iterator[str]:
    """A server of Fibonacci goals that the gateway knows; the path that goals are sent to."""
    path = f"/actions{namespace}/fibonacci"
    arguments = ("-r", f"__ns:={namespace}", "-p", "step_period:=0.05")
    with running_program(domain, "fibonacci_action_server", *arguments):
        wait_until(lambda: gateway.http.get(path).is_success, path)
        yield f"{path}/goals"


ENDED = {"Prefer": "wait=50"}


def ids(gateway: RunningGateway, query: str = "") -> list[str]:
    page = gateway.http.get(f"/goals{query}").raise_for_status().json()
    return [goal["goal_id"] for goal in page["goals"]]


def test_goals_of_every_action(gateway: RunningGateway, shared_domain: int) -> None:
    with fibonacci(shared_domain, gateway, "/robot1") as one, fibonacci(shared_domain, gateway, "/robot2") as two:
        first = gateway.http.post(one, json={"order": 3}, headers=ENDED).json()
        second = gateway.http.post(two, json={"order": 4}, headers=ENDED).json()
        assert (first["status"], second["status"]) == ("succeeded", "succeeded")
        assert ids(gateway) == [second["goal_id"], first["goal_id"]]
        client = ("fibonacci_action_client", "--ros-args", "-r", "__ns:=/robot1", "-p", "order:=5")
        with client_process(shared_domain, *client) as process:
            assert process.wait() == 0
        wait_until(lambda: len(ids(gateway, "?origin=external&status=succeeded")) == 1, "its goal")
        (external,) = ids(gateway, "?origin=external")
        running = gateway.http.post(two, json={"order": 40}).json()["goal_id"]
        assert ids(gateway, "?robot=/robot2") == [running, second["goal_id"]]
        assert ids(gateway, "?status=accepted&status=executing") == [running]
        known = first["goal_id"]
        for beginning in (known[:9], known, known.replace("-", "")[:14].upper()):
            assert ids(gateway, f"?id={beginning}") == [known]
        assert ids(gateway, f"?id={known}&robot=/robot2") == []
        path = f"/goals/{running}"
        assert gateway.http.get(path).json()["action_name"] == "/robot2/fibonacci"
        with gateway.http.stream("GET", f"{path}/events") as events:
            canceled = gateway.http.post(f"{path}/cancel")
            assert (canceled.status_code, canceled.headers["location"]) == (202, path)
            assert '"status":"canceled"' in "".join(events.iter_text())

    for action in ("/robot1/fibonacci", "/robot2/fibonacci"):
        wait_until(lambda at=f"/actions{action}": not gateway.http.get(at).is_success, "the action has gone")
    everything = [running, external, second["goal_id"], first["goal_id"]]
    assert ids(gateway) == everything, "the actions have gone, their goals are still listed"
    assert ids(gateway, "?robot=/robot1") == [external, first["goal_id"]]
    assert ids(gateway, "?action=/robot1/fibonacci&action=/robot2/fibonacci") == everything
    assert ids(gateway, f"?since={second['created_at']}&until={gateway.http.get(path).json()['created_at']}") == [
        external,
        second["goal_id"],
    ]
    pages, cursor = [], ""
    while cursor is not None:
        page = gateway.http.get(f"/goals?limit=3{cursor and f'&cursor={cursor}'}").json()
        pages.append([goal["goal_id"] for goal in page["goals"]])
        cursor = page["next_cursor"]
    assert pages == [everything[:3], everything[3:]]
    again = gateway.http.post(f"{path}/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "goal_terminal"), "also where nobody serves the action"


def test_the_history_of_a_goal(gateway: RunningGateway, shared_domain: int) -> None:
    with fibonacci(shared_domain, gateway, "/robot3") as path, gateway.stream("?action=/robot3/fibonacci") as stream:
        goal_id = gateway.http.post(path, json={"order": 10}, headers=ENDED).json()["goal_id"]
        stream.until_type("result")
    seen = [event for event in stream.seen if event.get("goal_id") == goal_id]
    history = f"/goals/{goal_id}/history"
    everything = gateway.http.get(history).raise_for_status().json()
    assert everything["events"] == seen, "exactly as on the WebSocket"
    assert (everything["complete"], everything["next_after"]) == (True, None)

    feedback = [event for event in seen if event["type"] == "feedback"]
    assert gateway.http.get(f"{history}?type=feedback").json()["events"] == feedback
    rest = gateway.http.get(f"{history}?type=status&type=result").json()["events"]
    assert rest == [event for event in seen if event["type"] != "feedback"]
    pages, after = [], ""
    while after is not None:
        page = gateway.http.get(f"{history}?limit=4{after and f'&after={after}'}").json()
        pages += page["events"]
        assert len(page["events"]) <= 4
        after = page["next_after"]
    assert pages == seen

    for query in ("after=7", "limit=0", "limit=5001", "type=results", "before=1"):
        assert gateway.http.get(f"{history}?{query}").json()["code"] == "invalid_field"
    missing = gateway.http.get("/goals/3f0c7b2e-0000-4000-8000-000000000000/history")
    assert (missing.status_code, missing.json()["code"]) == (404, "goal_not_found")


def test_exports(gateway: RunningGateway, shared_domain: int) -> None:
    with fibonacci(shared_domain, gateway, "/robot4") as path:
        goal = gateway.http.post(path, json={"order": 6}, headers=ENDED).json()
        gateway.http.post(path, json={"order": 3}, headers=ENDED)
    export = f"/goals/{goal['goal_id']}/export"
    feedback = gateway.http.get(f"/goals/{goal['goal_id']}/history?type=feedback").json()["events"]

    answer = gateway.http.get(f"{export}?format=csv")
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    assert answer.headers["content-disposition"] == f'attachment; filename="goal-{goal["goal_id"]}.csv"'
    rows = list(csv.DictReader(io.StringIO(answer.text, newline="")))
    assert [row["id"] for row in rows] == [event["id"] for event in feedback]
    assert list(rows[0])[:4] == ["time", "id", "partial_sequence.0", "partial_sequence.1"]
    assert [rows[-1][f"partial_sequence.{place}"] for place in range(7)] == ["0", "1", "1", "2", "3", "5", "8"]
    assert rows[0]["partial_sequence.6"] == ""

    exported = gateway.http.get(f"{export}?format=json").json()
    assert exported.pop("events") == gateway.http.get(f"/goals/{goal['goal_id']}/history").json()["events"]
    assert exported.pop("complete") is True
    assert exported == gateway.http.get(f"/goals/{goal['goal_id']}").json()

    listed = gateway.http.get("/goals?robot=/robot4").json()["goals"]
    answer = gateway.http.get("/goals/export?robot=/robot4&format=json")
    assert answer.json() == listed
    assert answer.headers["content-disposition"].startswith('attachment; filename="goals-2')
    rows = list(
        csv.DictReader(io.StringIO(gateway.http.get("/goals/export?robot=/robot4&format=csv").text, newline=""))
    )
    assert [row["goal_id"] for row in rows] == [each["goal_id"] for each in listed]
    assert (rows[1]["status"], rows[1]["goal"]) == ("succeeded", '{"order":6}')
    assert 0 < float(rows[1]["duration_s"]) < 60
    assert gateway.http.get("/goals/export?robot=/robot4&status=lost").json() == []
    assert gateway.http.get("/goals/export?robot=/robot5").json()["code"] == "robot_not_found"

    for refused in (f"{export}?format=xlsx", "/goals/export?limit=1", "/goals/export?status=done"):
        assert gateway.http.get(refused).json()["code"] == "invalid_field"
    missing = gateway.http.get("/goals/3f0c7b2e-0000-4000-8000-000000000000/export")
    assert (missing.status_code, missing.json()["code"]) == (404, "goal_not_found")


def test_notes_and_tags(gateway: RunningGateway, shared_domain: int) -> None:
    http = gateway.http
    with fibonacci(shared_domain, gateway, "/robot6") as path:
        first, second = (http.post(path, json={"order": 3}, headers=ENDED).json()["goal_id"] for _ in range(2))
        running = http.post(path, json={"order": 40}).json()["goal_id"]
        http.put(f"/goals/{running}/tags", json={"tags": ["late"]}).raise_for_status()
        assert ids(gateway, "?robot=/robot6&tag=late") == [running]
        http.post(f"/goals/{running}/cancel").raise_for_status()
    text = "wheel was blocked by a box"
    answer = http.post(f"/goals/{first}/notes", json={"by": "Ada", "text": text})
    assert (answer.status_code, answer.json()["text"]) == (201, text)
    http.put(f"/goals/{first}/tags", json={"tags": ["maintenance", "blocked"]}).raise_for_status()
    http.put(f"/goals/{second}/tags", json={"tags": ["blocked"]}).raise_for_status()
    assert http.get("/goals/tags").json()["tags"] == ["blocked", "late", "maintenance"]
    assert ids(gateway, "?tag=blocked") == [second, first]
    assert ids(gateway, "?tag=maintenance&tag=late") == [running, first]
    listed = http.get("/goals?tag=maintenance").json()["goals"]
    assert [goal["tags"] for goal in listed] == [["blocked", "maintenance"]]
    assert listed == [http.get(f"/goals/{first}").json()]
    assert listed[0]["notes"] == [answer.json()]
    assert http.get("/goals/export?tag=maintenance&format=json").json() == listed
    (row,) = csv.DictReader(io.StringIO(http.get("/goals/export?tag=maintenance&format=csv").text, newline=""))
    assert row["tags"] == "blocked; maintenance"
    exported = http.get(f"/goals/{first}/export").json()
    assert (exported["tags"], [note["text"] for note in exported["notes"]]) == (["blocked", "maintenance"], [text])


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("tag=", "tag"),
        (f"tag={'x' * 31}", "tag"),
        ("actoin=/dock", "actoin"),
        ("robot=robot1", "robot"),
        ("status=done", "status"),
        ("origin=me", "origin"),
        ("since=yesterday", "since"),
        ("since=2026-11-22T00:00:00Z&until=2026-11-21T00:00:00Z", "since"),
        ("since=2026-11-21T03:32:40", "since"),
        ("since=0.5", "since"),
        ("since=1795232000", "since"),
        ("since=2026-11-21", "since"),
        ("action=no%20name", "action"),
        ("until=0001-01-01T00:00:00%2B14:00", "until"),
        ("id=abc", "id"),
        ("id=a-b-c", "id"),
        ("id=abcdefg", "id"),
        ("id=4f1c%25", "id"),
        ("id=", "id"),
        (f"id={'0' * 33}", "id"),
        ("limit=501", "limit"),
        ("cursor=3f0c7b2e-0000-4000-8000-000000000000", "cursor"),
    ],
)
def test_what_is_refused(gateway: RunningGateway, query: str, field: str) -> None:
    answer = gateway.http.get(f"/goals?{query}")
    assert answer.status_code == 422, answer.text
    assert [(error["in"], error["path"]) for error in answer.json()["errors"]] == [("query", field)]


def test_a_goal_that_is_not_there(gateway: RunningGateway) -> None:
    for path in ("", "/events"):
        answer = gateway.http.get(f"/goals/3f0c7b2e-0000-4000-8000-000000000000{path}")
        assert (answer.status_code, answer.json()["code"]) == (404, "goal_not_found")
