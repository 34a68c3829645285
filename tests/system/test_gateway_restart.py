"""A gateway that is killed and started again: no goal that was answered with 202 is ever missing."""

import signal
import sqlite3
import time
import uuid
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from sensor_msgs.msg import BatteryState

from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal
from dock_gateway.ros.messages.codec import codec
from dock_gateway.settings import Settings
from tests.support.gateway import ACTION, CHARGING, IMPATIENT, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.history import open_at
from tests.support.observer import Observer, ros_observer
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@pytest.fixture
def database(tmp_path: Path) -> Path:
    return tmp_path / "history.sqlite3"


@pytest.fixture
def kept(database: Path, tmp_path: Path) -> dict[str, str]:
    """Where one gateway after the other keeps its goals."""
    return {"database_url": f"sqlite:///{database}", "spool_path": str(tmp_path / "spool")}


def kill(gateway: RunningGateway) -> None:
    gateway.process.send_signal(signal.SIGKILL)
    gateway.process.wait()


def battery(domain: int, status: int) -> Process:
    """A battery driver of its own, which outlives the gateway."""
    command = ("-m", "tests.support.battery", str(status))
    return ForkedProcess(*command, env=ros_environment(domain))


def test_a_running_goal_is_taken_up_streams_and_ends(domain: int, kept: dict[str, str]) -> None:
    with running_dock_server(domain), battery(domain, 3) as low:
        with running_gateway(domain, **kept) as first:
            first.wait_until_ready()
            headers = {"Idempotency-Key": "dock-once"}
            sent = first.http.post("/dock", json={"desired_battery_state": CHARGING}, headers=headers).json()
            with first.stream(f"?goal_id={sent['goal_id']}") as stream:
                last = stream.until_type("feedback")["id"]
            kill(first)
        with running_gateway(domain, **kept) as second:
            started = time.monotonic()
            goal = second.goal(sent["goal_id"])
            assert (goal["origin"], goal["goal"]) == ("gateway", sent["goal"])
            with second.stream(f"?goal_id={sent['goal_id']}") as stream:
                stream.until_type("feedback")
                assert time.monotonic() - started < 6  # the promise is 3 s; a machine that is shared gets twice that
                assert second.http.post("/dock", headers=headers).json()["code"] == "idempotency_key_reused"
                again = second.http.post("/dock", json={"desired_battery_state": CHARGING}, headers=headers).json()
                assert again["goal_id"] == sent["goal_id"]
                low.send_signal(signal.SIGTERM)
                low.wait()
                with battery(domain, 1):
                    result = stream.until_type("result")
            assert result["status"] == "succeeded"
            with second.stream(f"?goal_id={sent['goal_id']}&after={last}") as resumed:
                assert resumed.next()["type"] in ("resumed", "gap")
            goal = second.goal(sent["goal_id"])
            assert (goal["status"], goal["result"]["final_battery_state"]["power_supply_status"]) == ("succeeded", 1)


def test_goals_that_ended_meanwhile_get_their_result(domain: int, kept: dict[str, str]) -> None:
    with running_dock_server(domain):
        with running_gateway(domain, **kept) as first, battery(domain, 3):
            first.wait_until_ready()
            goal_id = first.http.post("/dock").json()["goal_id"]
            first.wait_for_goal(goal_id, "executing")
            kill(first)
        with battery(domain, 1), ros_observer(domain) as observer:
            wait_for_status(observer, 4)
        with running_gateway(domain, **kept) as second:
            goal = second.wait_for_goal(goal_id, "succeeded")
            assert goal["result"]["final_battery_state"]["power_supply_status"] == 1


def test_after_six_restarts_each_goal_has_ended_once(domain: int, kept: dict[str, str]) -> None:
    """The action server tells of its goals again each time; a reader that resumes is told of each end once."""
    goals: list[str] = []
    seen: list[dict[str, Any]] = []
    documents: dict[str, Any] = {}
    with running_dock_server(domain), battery(domain, 1):
        for _ in range(6):
            with running_gateway(domain, **kept) as gateway:
                gateway.wait_until_ready()
                after = f"?after={max(event['id'] for event in seen)}" if seen else ""
                with gateway.stream(after) as stream:
                    assert stream.next()["type"] == ("resumed" if seen else "snapshot")
                    goals.append(gateway.http.post("/dock").raise_for_status().json()["goal_id"])
                    ended = stream.until_type("result")
                    assert ended["goal_id"] == goals[-1]
                    seen += [event for event in stream.seen if "id" in event]
                for goal_id, document in documents.items():
                    assert gateway.goal(goal_id) == document, "a goal that has ended does not change"
                documents[goals[-1]] = gateway.goal(goals[-1])
                assert [alert["kind"] for alert in gateway.http.get("/alerts").json()["alerts"]] == []
                kill(gateway)
    assert len({event["id"] for event in seen}) == len(seen)
    assert [event["id"] for event in seen] == sorted(event["id"] for event in seen)
    assert [event["goal_id"] for event in seen if event["type"] == "result"] == goals
    assert [e["goal_id"] for e in seen if e["type"] == "status" and e["status"] == "succeeded"] == goals


async def test_a_goal_that_was_stored_and_not_sent_is_sent_by_a_retry(
    domain: int, kept: dict[str, str], observer: Observer
) -> None:
    """What a gateway leaves that is killed between the two."""
    asked = codec(BatteryState).encode(codec(BatteryState).parse(CHARGING))
    message = b'{"desired_battery_state":%s}' % asked
    goal = Goal(str(uuid.uuid4()), ACTION, Settings().dock_action_type, utc_now(), goal=message)
    async with open_at(kept["database_url"], Path(kept["spool_path"]).parent) as history:
        await history.add(goal, "dock-once")
    with running_dock_server(domain), battery(domain, 1), running_gateway(domain, **kept) as gateway:
        gateway.wait_until_ready()
        lost = gateway.wait_for_goal(goal.goal_id, "lost")
        assert lost["error"]["code"] == "goal_unconfirmed"
        headers = {"Idempotency-Key": "dock-once", "Prefer": "wait=50"}
        for _ in range(2):
            answer = gateway.http.post("/dock", json={"desired_battery_state": CHARGING}, headers=headers)
            assert (answer.json()["goal_id"], answer.json()["status"]) == (goal.goal_id, "succeeded")
        assert answer.json()["error"] is None
        assert [entry["goal_id"] for entry in gateway.http.get("/dock").json()["goals"]] == [goal.goal_id]


def wait_for_status(observer: Observer, status: int) -> None:
    from action_msgs.msg import GoalStatusArray
    from rclpy.qos import qos_profile_action_status_default

    topic = "/connect_to_charging_dock/_action/status"
    recording = observer.record(GoalStatusArray, topic, qos_profile_action_status_default)
    recording.wait_for(lambda message: any(entry.status == status for entry in message.status_list))


def test_goals_whose_server_has_gone_are_lost_not_forgotten(domain: int, kept: dict[str, str]) -> None:
    with running_gateway(domain, **kept) as first, running_dock_server(domain) as server:
        first.wait_until_ready()
        first.publish(LOW)
        goal_id = first.http.post("/dock").json()["goal_id"]
        first.wait_for_goal(goal_id, "executing")
        kill(first)
        server.send_signal(signal.SIGKILL)
        server.wait()
    with running_gateway(domain, **kept) as second:
        assert second.goal(goal_id)["origin"] == "gateway"
        goal = second.wait_for_goal(goal_id, "lost")
        assert goal["error"]["code"] == "action_server_lost"
        with running_dock_server(domain):
            second.wait_until_ready()
            assert second.http.post("/dock").status_code == 202
            assert [entry["goal_id"] for entry in second.http.get("/dock").json()["goals"]][1] == goal_id


@pytest.mark.parametrize("served", [True, False])
def test_goals_are_taken_up_when_the_database_is_back(
    domain: int, kept: dict[str, str], database: Path, served: bool
) -> None:
    """It was away when the gateway started, so that nobody knew of them, or whose they were."""
    with running_dock_server(domain) as server, battery(domain, 3):
        with running_gateway(domain, **kept) as first:
            first.wait_until_ready()
            goal_id = first.http.post("/dock").json()["goal_id"]
            first.wait_for_goal(goal_id, "executing")
            first.wait_until_stored()
            kill(first)
        if not served:
            server.send_signal(signal.SIGKILL)
            server.wait()
        with closing(sqlite3.connect(database, isolation_level=None)) as other:
            other.execute("BEGIN EXCLUSIVE")
            with running_gateway(domain, **kept) as second:

                def origin() -> str | None:
                    origin: str | None = second.http.get(f"/dock/{goal_id}").json().get("origin")
                    return origin

                def reachable() -> bool:
                    return bool(second.http.get("/readyz").json()["history"]["database_reachable"])

                assert not reachable()
                if served:
                    wait_until(lambda: origin() == "external", "the goal, as the action server tells of it")
                else:
                    assert second.http.get(f"/dock/{goal_id}").json()["code"] == "history_unavailable"
                other.execute("ROLLBACK")
                wait_until(reachable, "the database")
                wait_until(lambda: origin() == "gateway", "the goal, as the database tells of it")
                second.wait_for_goal(goal_id, "executing" if served else "lost")


def test_a_goal_that_was_never_sent_does_not_use_up_its_key(domain: int, kept: dict[str, str]) -> None:
    # The gateway does not look whether the server is there while this goes on: it finds out as it sends the goal.
    blind = {**IMPATIENT, "ping_interval": "60", "stalled_after": "120", "lost_after": "240", **kept}
    headers = {"Idempotency-Key": "once"}
    with running_gateway(domain, **blind) as gateway:
        with running_dock_server(domain):
            gateway.wait_until_ready()
            gateway.publish(LOW)
            gateway.http.post("/dock").raise_for_status()
            (canceled,) = gateway.stop_once()["canceling"]
            gateway.wait_for_goal(canceled, "canceled")
        refused = gateway.http.post("/dock", headers=headers)
        assert (refused.status_code, refused.json()["code"]) == (503, "action_server_unavailable")
        (kept,) = gateway.http.get("/dock?status=rejected").json()["goals"]
        assert kept["error"]["code"] == "action_server_unavailable"
        with running_dock_server(domain):
            wait_until(lambda: gateway.http.post("/dock", headers=headers).status_code == 202, "a retry is accepted")
            (running,) = gateway.http.get("/dock?status=accepted&status=executing").json()["goals"]
            assert gateway.http.post("/dock", headers=headers).json()["goal_id"] == running["goal_id"]
