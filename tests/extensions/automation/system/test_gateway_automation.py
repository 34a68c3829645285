"""Automatic docking by real gateways: when a robot docks by itself, when it does not, and that it docks once."""

import math
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sensor_msgs.msg import BatteryState

from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway, running_dock_server, running_gateway
from tests.support.observer import Observer, ros_observer
from tests.support.postgresql import binaries, running_postgresql
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

RULES = "/automation/rules"
RULE = {"name": "Low battery", "robots": {"all": True}, "battery": {"below": 0.3, "idle_s": 10}, "by": "Ada"}
# A frozen server must not be noticed before the goal is sent to it.
UNWATCHED = {"ping_interval": "60", "stalled_after": "120", "lost_after": "240"}


@pytest.fixture
def database(tmp_path: Path) -> Iterator[str]:
    if binaries() is None:
        yield f"sqlite:///{tmp_path}/history.db"
        return
    with running_postgresql() as server:
        yield server.url


def decisions(gateway: RunningGateway, query: str = "") -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = (
        gateway.http.get(f"/automation/decisions{query}").raise_for_status().json()["decisions"]
    )
    return found


def outcomes(gateway: RunningGateway) -> list[str]:
    """What came of the decisions, oldest first."""
    return [decision["outcome"] for decision in reversed(decisions(gateway))]


def goals(gateway: RunningGateway) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = gateway.http.get("/dock").raise_for_status().json()["goals"]
    return found


def put(gateway: RunningGateway, rule_id: str = "low-battery", **fields: Any) -> dict[str, Any]:
    rule: dict[str, Any] = gateway.http.put(f"{RULES}/{rule_id}", json=RULE | fields).raise_for_status().json()
    return rule


def waits_for(gateway: RunningGateway) -> list[str]:
    """What the one rule waits for, by robot."""
    (rule,) = gateway.http.get(RULES).raise_for_status().json()["rules"]
    return [robot["waits_for"] for robot in rule["applies_to"]]


def test_two_gateways_dock_a_robot_once(domain: int, database: str) -> None:
    with (
        running_dock_server(domain),
        running_gateway(domain, database_url=database) as first,
        running_gateway(domain, database_url=database) as second,
        second.stream("?include=fleet") as stream,
    ):
        for gateway in (first, second):
            gateway.wait_until_ready()
            gateway.wait_until_stored()
        first.publish(LOW)
        assert put(first)["mode"] == "off"
        assert waits_for(second) == ["off"]
        put(second, mode="dry_run")
        wait_until(lambda: outcomes(first) == ["dry_run"], "a dry run")
        assert goals(first) == []
        put(first, mode="on")
        sent = stream.until(lambda event: event["type"] == "automation" and event["automation"]["outcome"] == "sent")
        (goal,) = wait_until(lambda: goals(second), "the goal")
        assert goal["goal_id"] == sent["automation"]["goal_id"]
        assert (goal["origin"], goal["goal"]["desired_battery_state"]["power_supply_status"]) == ("automation", 1)
        assert sent["automation"]["battery"] == pytest.approx(0.24)
        for gateway in (first, second):
            wait_until(lambda gateway=gateway: outcomes(gateway) == ["dry_run", "sent"], "the same decisions")
            (found,) = decisions(gateway, f"?goal_id={goal['goal_id']}&robot=/&rule=low-battery&limit=1")
            assert found == sent["automation"]
        by_origin = second.http.get("/goals?origin=automation").raise_for_status().json()["goals"]
        assert [each["goal_id"] for each in by_origin] == [goal["goal_id"]]
        first.publish(CHARGING)
        first.wait_for_goal(goal["goal_id"], "succeeded")
        wait_until(lambda: waits_for(first) == ["docked"] == waits_for(second), "a robot at its dock")
        assert len(goals(second)) == 1
    written = "".join(gateway.process.output for gateway in (first, second))
    assert written.count("automatic docking of / by the rule") == 2  # one line for each decision


def test_a_stop_holds_a_robot_that_should_dock(domain: int) -> None:
    with ready_gateway(domain) as gateway:
        put(gateway, mode="on")
        gateway.http.post("/stop", json={"by": "Bob"}).raise_for_status()
        gateway.publish(LOW)
        (held,) = wait_until(lambda: decisions(gateway), "a decision")
        assert (held["outcome"], held["code"], held["goal_id"]) == ("held", "stop_latched", None)
        assert held["detail"].startswith("stopped by Bob at ")
        assert goals(gateway) == []
        gateway.http.delete("/stop").raise_for_status()
        wait_until(lambda: waits_for(gateway) == ["stopped"], "somebody to say that it goes on")
        (hold,) = gateway.http.get("/automation/holds").raise_for_status().json()["holds"]
        assert hold["robot"] == "/"
        unknown = gateway.http.delete("/automation/holds?robot=/nobody")
        assert (unknown.status_code, unknown.json()["code"]) == (404, "robot_not_found")
        for _ in range(2):
            assert gateway.http.delete("/automation/holds").status_code == 204
        assert gateway.http.get("/automation/holds").json() == {"holds": []}
        wait_until(lambda: waits_for(gateway) == ["not_idle"], "idle time")
        gateway.http.delete("/battery/publisher").raise_for_status()
        wait_until(lambda: waits_for(gateway) == ["battery_unknown"], "silence")
        assert goals(gateway) == []
        assert gateway.http.delete(f"{RULES}/low-battery").status_code == 204
        assert gateway.http.get(f"{RULES}/low-battery").json()["code"] == "rule_not_found"


def test_robots_that_share_a_docking_action_are_not_docked(domain: int) -> None:
    """Nothing tells which of them a goal would dock. A robot alone is docked, though the default one is known, too."""
    low = BatteryState(voltage=1.6, percentage=0.1, power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
    with (
        running_dock_server(domain),
        running_gateway(domain, dock_action="/connect_to_charging_dock") as gateway,
        ros_observer(domain) as observer,
        observer.publishing(low, "/robot2/battery_status"),
    ):
        gateway.wait_until_ready()
        put(gateway, mode="dry_run")
        wait_until(lambda: outcomes(gateway) == ["dry_run"], "a dry run, as /robot2 is the only robot that is there")
        with observer.publishing(low, "/robot3/battery_status"):
            wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) == 3, "the other robot")
            put(gateway, mode="on")
            wait_until(lambda: waits_for(gateway) == ["battery_unknown", "shared_action", "shared_action"], "no goal")
        assert goals(gateway) == []


def test_a_gateway_that_is_killed_while_it_sends_a_goal_sends_no_other(domain: int, tmp_path: Path) -> None:
    database = f"sqlite:///{tmp_path}/history.db"
    with running_dock_server(domain) as server:
        with running_gateway(domain, database_url=database, **UNWATCHED) as gateway:
            gateway.wait_until_ready()
            gateway.publish(LOW)
            put(gateway, mode="on")
            wait_until(lambda: waits_for(gateway) == ["not_idle"], "a low battery")
            server.send_signal(signal.SIGSTOP)
            try:
                (goal,) = wait_until(lambda: goals(gateway), "the goal")
                assert outcomes(gateway) == ["sending"]
                gateway.process.send_signal(signal.SIGKILL)
                gateway.process.wait()
            finally:
                server.send_signal(signal.SIGCONT)
        with running_gateway(domain, database_url=database) as gateway:
            gateway.wait_until_ready()
            gateway.publish(LOW)
            wait_until(lambda: waits_for(gateway) in (["retry_later"], ["goal_running"], ["goal_lost"]), "no other")
            assert outcomes(gateway) == ["sending"]  # until it is a minute old
            assert [each["goal_id"] for each in goals(gateway)] == [goal["goal_id"]]


def test_a_percentage_that_cannot_be_right_is_waited_for(domain: int, observer: Observer) -> None:
    state = BatteryState(voltage=12.0, percentage=math.inf, power_supply_status=2)
    with running_gateway(domain) as gateway, observer.publishing(state, "/battery_status"):
        gateway.http.put(f"{RULES}/low", json=RULE | {"mode": "on"}).raise_for_status()

        def waits() -> list[str]:
            (rule,) = gateway.http.get(RULES).json()["rules"]
            return [each["waits_for"] for each in rule["applies_to"]]

        wait_until(lambda: waits() == ["battery_unknown"], "a rule that waits")
