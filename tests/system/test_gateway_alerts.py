"""Alerts of a real gateway: they come, are acknowledged, hold elsewhere and after a restart, and end."""

import signal
import time
from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.gateway import CHARGING, LOW, RunningGateway, Stream, running_dock_server, running_gateway
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

EMPTY = {"percentage": 0.1, "power_supply_status": 2}
FULL_ENOUGH = {"percentage": 0.6, "power_supply_status": 2}
QUICK = {"battery_stale_after": "0.8", "ping_interval": "0.5", "stalled_after": "1.5", "lost_after": "2.5"}


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> str:
    return f"sqlite:///{tmp_path_factory.mktemp('history')}/history.db"


@pytest.fixture(scope="module")
def running(shared_domain: int, database: str) -> Iterator[RunningGateway]:
    with running_gateway(shared_domain, database_url=database, **QUICK) as gateway:
        yield gateway


@pytest.fixture
def gateway(running: RunningGateway) -> Iterator[RunningGateway]:
    """A gateway without alerts, before and after."""
    running.publish(FULL_ENOUGH)
    wait_until(lambda: alerts(running) == [], "no alerts")
    yield running
    running.http.delete("/stop").raise_for_status()


def alerts(gateway: RunningGateway) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = gateway.http.get("/alerts").raise_for_status().json()["alerts"]
    return found


def until_alerts(stream: Stream, *kinds: str, timeout: float = PATIENCE) -> list[dict[str, Any]]:
    """Read on until these are the alerts."""

    def matches(event: dict[str, Any]) -> bool:
        return event["type"] == "alerts" and [alert["kind"] for alert in event["alerts"]] == list(kinds)

    found: list[dict[str, Any]] = stream.until(matches, timeout)["alerts"]
    return found


def acknowledger(gateway: RunningGateway, alert_id: str) -> str | None:
    """Who has acknowledged an alert here; "no alert" where there is none."""
    alert = next((alert for alert in alerts(gateway) if alert["id"] == alert_id), None)
    return "no alert" if alert is None else (alert["acknowledged"] or {}).get("by")


def test_a_low_battery_is_acknowledged_everywhere_until_it_is_over(
    shared_domain: int, database: str, gateway: RunningGateway
) -> None:
    with gateway.stream("?include=fleet") as stream:
        assert stream.next()["alerts"] == []
        gateway.publish(EMPTY)
        (alert,) = until_alerts(stream, "low_battery")
        assert (alert["robot"], alert["severity"], alert["acknowledged"]) == ("/", "warning", None)
        path = f"/alerts/{alert['id']}/acknowledgement"
        seen = gateway.http.put(path, json={"by": " Ada "}).raise_for_status().json()
        assert seen["acknowledged"]["by"] == "Ada"
        assert until_alerts(stream, "low_battery") == [seen] == alerts(gateway)
        with running_gateway(shared_domain, database_url=database, **QUICK) as other:
            wait_until(lambda: acknowledger(other, alert["id"]) == "Ada", "the alert, acknowledged")
            assert other.http.delete(path).status_code == 204
            wait_until(lambda: acknowledger(gateway, alert["id"]) is None, "nobody has acknowledged it")
            other.http.put(path, json={"by": "Bob"}).raise_for_status()
            wait_until(lambda: acknowledger(gateway, alert["id"]) == "Bob", "Bob has acknowledged it")
        gateway.publish(FULL_ENOUGH)
        assert until_alerts(stream) == []
        gateway.publish(EMPTY)
        (again,) = until_alerts(stream, "low_battery")
        assert (again["id"], again["acknowledged"]) == (alert["id"], None)


def test_what_cannot_be_acknowledged(gateway: RunningGateway) -> None:
    gateway.http.post("/stop", json={"by": "Ada"}).raise_for_status()
    (alert,) = wait_until(lambda: alerts(gateway), "the stop")
    assert (alert["kind"], alert["severity"]) == ("stop_latched", "critical")
    assert alert["detail"].startswith("Ada stopped /")
    path = f"/alerts/{alert['id']}/acknowledgement"
    for body in ({}, {"by": ""}, {"by": " \t"}, {"by": "a" * 61}, {"by": 7}, {"by": "a\nb"}, {"by": "a", "x": 1}):
        answer = gateway.http.put(path, json=body)
        assert (answer.status_code, answer.json()["code"]) == (422, "invalid_field"), body
    unknown = gateway.http.put("/alerts/0000/acknowledgement", json={"by": "Ada"})
    assert (unknown.status_code, unknown.json()["code"]) == (404, "alert_not_found")
    gateway.http.delete("/stop").raise_for_status()
    wait_until(lambda: alerts(gateway) == [], "the end of the stop")


def test_a_battery_that_falls_silent(gateway: RunningGateway) -> None:
    gateway.http.delete("/battery/publisher").raise_for_status()
    (alert,) = wait_until(lambda: alerts(gateway), "silence")
    assert (alert["kind"], alert["robot"]) == ("battery_stale", "/")


def test_a_robot_that_is_docked_and_not_charged_then_one_that_is_lost(
    shared_domain: int, gateway: RunningGateway
) -> None:
    with gateway.stream("?include=fleet&feedback=false") as stream:
        with running_dock_server(shared_domain) as server:
            gateway.wait_until_ready()
            gateway.publish(CHARGING)
            goal = gateway.http.post("/dock", headers={"Prefer": "wait=50"}).raise_for_status().json()
            assert goal["status"] == "succeeded"
            gateway.publish(FULL_ENOUGH)
            (alert,) = until_alerts(stream, "discharging_on_dock")
            assert alert["severity"] == "critical"
            gateway.publish(LOW)
            goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
            assert until_alerts(stream) == []  # somebody sees to it
            server.send_signal(signal.SIGKILL)
        (lost,) = until_alerts(stream, "goal_lost")
        assert (lost["goal_id"], lost["robot"]) == (goal_id, "/")


def test_a_lost_goal_is_over_when_the_robot_has_docked(shared_domain: int, running: RunningGateway) -> None:
    """Each goal of several is lost with its server; then the server is back, and the robot docks."""
    for _ in range(2):
        with running_dock_server(shared_domain) as server:
            running.wait_until_ready()
            running.publish(LOW)
            goal_id = running.http.post("/dock").raise_for_status().json()["goal_id"]
            running.wait_for_goal(goal_id, "executing")
            server.send_signal(signal.SIGKILL)
            running.wait_for_goal(goal_id, "lost")
            wait_until(lambda lost=goal_id: [each["goal_id"] for each in alerts(running)] == [lost], "one alert")
    with running_dock_server(shared_domain):
        running.wait_until_ready()
        assert [alert["kind"] for alert in alerts(running)] == ["goal_lost"]  # nothing is known of the robot yet
        running.publish(CHARGING)
        goal = running.http.post("/dock", headers={"Prefer": "wait=50"}).raise_for_status().json()
        assert goal["status"] == "succeeded"
        wait_until(lambda: alerts(running) == [], "no alert")
        refused = running.http.post("/dock", json={"desired_battery_state": {"power_supply_status": 3}})
        assert refused.json()["code"] == "goal_rejected"  # it tells nothing, and changes nothing
        time.sleep(1.2)  # two looks
        assert alerts(running) == []
