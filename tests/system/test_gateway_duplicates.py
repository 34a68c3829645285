"""Two action servers with one name would both move the robot."""

import signal
from collections.abc import Iterator
from typing import Any

import pytest

from action_tutorials_interfaces.action import ConnectToChargingDock
from tests.support.gateway import ACTION, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain) as gateway:
        yield gateway


def alerts(gateway: RunningGateway) -> list[dict[str, Any]]:
    found = gateway.http.get("/alerts").json()["alerts"]
    return [alert for alert in found if alert["kind"] == "duplicate_action_server"]


def test_two_servers_raise_an_alert_and_get_no_goal(gateway: RunningGateway, domain: int, observer: Observer) -> None:
    with running_dock_server(domain) as first, gateway.stream("?include=system") as stream:
        gateway.wait_until_ready()
        assert not gateway.http.get(f"/actions{ACTION}").json()["duplicate"]
        with running_dock_server(domain) as second:
            stream.until(lambda e: e["type"] == "action_server" and e["action_server"]["duplicate"])
            (alert,) = wait_until(lambda: alerts(gateway), "the alert")
            assert (alert["robot"], alert["severity"]) == ("/", "critical")
            assert ACTION in alert["detail"]
            refused = gateway.http.post("/dock")
            assert (refused.status_code, refused.json()["code"]) == (409, "duplicate_action_server")
            assert gateway.http.get(f"/actions{ACTION}").json()["duplicate"]
            assert gateway.http.get("/robots").json()["robots"][0]["dock"]["duplicate"]
            assert gateway.http.get("/readyz").status_code == 503

            # Another client's goal reaches both. A stop does, too.
            gateway.publish(LOW)
            send_goal = f"{ACTION}/_action/send_goal"
            wait_until(lambda: observer.node.count_services(send_goal) == 2, "the other client finds both servers")
            goal = observer.send_goal(ConnectToChargingDock, ACTION, ConnectToChargingDock.Goal())
            for server in (first, second):
                server.wait_for("Executing goal...")
            stream.until(lambda e: e["type"] == "feedback" and e["goal_id"] == goal.goal_id)
            gateway.stop_once()
            for server in (first, second):
                server.wait_for("canceled")

            second.send_signal(signal.SIGTERM)
            assert second.wait() == 0
        gateway.wait_until_ready()
        wait_until(lambda: not alerts(gateway), "the end of the alert")
        assert gateway.http.post("/dock").status_code == 202


def test_a_killed_server_and_its_successor_are_not_taken_for_two(gateway: RunningGateway, domain: int) -> None:
    with running_dock_server(domain) as server, gateway.stream("?include=system") as stream:
        gateway.wait_until_ready()
        server.send_signal(signal.SIGKILL)
        server.wait()
        stream.until(lambda e: e["type"] == "action_server" and not e["action_server"]["answering"])
        with running_dock_server(domain):
            stream.until(lambda e: e["type"] == "action_server" and e["action_server"]["answering"])
            gateway.publish(LOW)
            assert gateway.http.post("/dock").status_code == 202
            assert not [e for e in stream.seen if e["type"] == "action_server" and e["action_server"]["duplicate"]]
            assert alerts(gateway) == []


def test_two_servers_can_be_allowed(domain: int) -> None:
    with (
        running_gateway(domain, allow_duplicate_servers="true") as gateway,
        running_dock_server(domain),
        running_dock_server(domain),
    ):
        wait_until(lambda: alerts(gateway), "the alert")
        gateway.publish(LOW)
        assert gateway.http.post("/dock").status_code == 202
