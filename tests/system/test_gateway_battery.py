"""What real drivers say of their batteries: what is believed, what is not, and what is said about it."""

import math
from collections.abc import Iterator
from typing import Any

import pytest
from sensor_msgs.msg import BatteryState

from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

TO_100 = '{"*": {"battery": {"percentage": "0-100"}}}'
SETTING = 'battery.percentage = "0-100"'


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain) as gateway:
        yield gateway


def battery(gateway: RunningGateway, robot: str = "/") -> dict[str, Any]:
    answer: dict[str, Any] = gateway.http.get(f"/battery?robot={robot}").raise_for_status().json()
    return answer


def alerts(gateway: RunningGateway) -> dict[str, dict[str, Any]]:
    found = gateway.http.get("/alerts").raise_for_status().json()["alerts"]
    return {alert["kind"]: alert for alert in found}


def robot(gateway: RunningGateway, name: str = "/") -> dict[str, Any]:
    (found,) = gateway.http.get(f"/robots?robot={name}").raise_for_status().json()["robots"]
    assert isinstance(found, dict)
    return found


def test_a_percentage_that_cannot_be_right_is_named_and_not_used(gateway: RunningGateway, observer: Observer) -> None:
    state = BatteryState(voltage=12.0, percentage=math.inf, power_supply_status=2)
    with gateway.stream("?include=battery") as stream, observer.publishing(state, "/battery_status"):
        sent = stream.until_type("battery")["battery"]
        wrong = [{"field": "percentage", "value": "inf", "expected": "0 to 1"}]
        assert (sent["state"]["percentage"], sent["percentage"], sent["implausible"]) == (None, None, wrong)
        answer = battery(gateway)
        assert (answer["state"]["percentage"], answer["percentage"], answer["implausible"]) == (None, None, wrong)
        assert robot(gateway)["battery"]["percentage"] is None
        alert = wait_until(lambda: alerts(gateway).get("battery_implausible"), "the alert")
        assert (alert["robot"], alert["severity"]) == ("/", "warning")
        for named in ("/battery_status", "percentage", "inf", "0 to 1", SETTING):
            assert named in alert["detail"]
        assert list(alerts(gateway)) == ["battery_implausible"]
        history = gateway.http.get("/battery/history").raise_for_status().json()
        assert set(history["percentage"]["mean"]) == {None}
        assert set(history["voltage"]["mean"]) == {12.0}


def test_it_is_over_once_values_are_right_for_a_while(gateway: RunningGateway, observer: Observer) -> None:
    wrong = BatteryState(voltage=12.0, percentage=12.0, power_supply_status=2)
    right = BatteryState(voltage=12.0, percentage=0.12, power_supply_status=2)
    with observer.publishing(right, "/battery_status"):
        wait_until(lambda: list(alerts(gateway)) == ["low_battery"], "a low battery")
        observer.publish(wrong, "/battery_status")
        before = wait_until(lambda: alerts(gateway).get("battery_implausible"), "the alert")
        assert battery(gateway)["percentage"] is None  # right ones come meanwhile
        assert set(alerts(gateway)) == {"low_battery", "battery_implausible"}
        wait_until(lambda: list(alerts(gateway)) == ["low_battery"], "the end of the alert")
        assert battery(gateway)["percentage"] == pytest.approx(0.12)
        assert before["started_at"]


def test_a_driver_that_counts_to_100_by_the_setting(domain: int, observer: Observer) -> None:
    state = BatteryState(voltage=12.0, percentage=12.0, power_supply_status=2)
    with (
        running_gateway(domain, robots='{"/a": {"battery": {"percentage": "0-100"}}}') as gateway,
        observer.publishing(state, "/a/battery_status", heard=False),
        observer.publishing(state, "/b/battery_status", heard=False),
    ):
        wait_until(lambda: {a["kind"] for a in gateway.http.get("/alerts").json()["alerts"]}, "the alerts")

        def found() -> set[tuple[str, str]]:
            return {(a["robot"], a["kind"]) for a in gateway.http.get("/alerts").json()["alerts"]}

        wait_until(lambda: found() == {("/a", "low_battery"), ("/b", "battery_implausible")}, "both alerts")
        answer = battery(gateway, "/a")
        assert (answer["state"]["percentage"], answer["percentage"], answer["implausible"]) == (12.0, 0.12, [])
        history = gateway.http.get("/battery/history?robot=/a").raise_for_status().json()
        assert set(history["percentage"]["mean"]) == {0.12}
    with (
        running_gateway(domain, robots=TO_100) as gateway,
        observer.publishing(state, "/battery_status"),
    ):
        wait_until(lambda: battery(gateway)["percentage"] == 0.12, "12 %")


@needs("simulator")
def test_the_simulators_fault_is_one_of_them(domain: int) -> None:
    with running_program(domain, "dock_simulator"), running_gateway(domain) as gateway:
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        wait_until(lambda: battery(gateway)["percentage"], "the battery")
        assert alerts(gateway) == {}
        gateway.set_fault("percentage_0_to_100")
        alert = wait_until(lambda: alerts(gateway).get("battery_implausible"), "the alert")
        assert SETTING in alert["detail"]
        assert battery(gateway)["percentage"] is None
        gateway.set_fault("percentage_0_to_100", active=False)
        wait_until(lambda: alerts(gateway) == {}, "no alert")
        assert battery(gateway)["percentage"] == pytest.approx(0.24, abs=0.02)


@needs("simulator")
def test_a_docked_robot_whose_battery_has_no_status(domain: int) -> None:
    """As the Create 3: the current says that it charges; nothing is low, and nothing has to dock."""
    parameters = ("battery_reports_status:=false", "battery_start:=0.1", "battery_charges_negative:=true")
    arguments = [part for parameter in parameters for part in ("-p", parameter)]
    with (
        running_program(domain, "dock_simulator", *arguments),
        running_gateway(domain, robots='{"*": {"battery": {"charging_current": "negative"}}}') as gateway,
    ):
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        alert = wait_until(lambda: alerts(gateway).get("low_battery"), "a low battery")
        assert "Send the robot to its dock" in alert["detail"]
        assert robot(gateway)["charging"] is None
        gateway.http.post("/simulator/place", json={"x": 0.0, "y": 0.0, "theta": 0.0}).raise_for_status()
        wait_until(lambda: robot(gateway)["docked"], "the dock")
        wait_until(lambda: robot(gateway)["charging"], "charging")
        wait_until(lambda: alerts(gateway) == {}, "no alert")
        gateway.set_fault("dead_charger")
        wait_until(lambda: "discharging_on_dock" in alerts(gateway), "the alert of a dead charger")
        assert robot(gateway)["charging"] is False
        assert "although it is docked" in alerts(gateway)["low_battery"]["detail"]


def test_a_battery_that_never_came_names_the_others(gateway: RunningGateway, observer: Observer) -> None:
    state = BatteryState(voltage=12.0, percentage=0.5, power_supply_status=2)
    observer.record(BatteryState, "/docking/battery_status")  # who only listens has no battery
    assert battery(gateway)["other_topics"] == []
    with (
        observer.publishing(state, "/base/battery_state", heard=False),
        observer.publishing(state, "/a/battery_status"),
    ):
        wait_until(lambda: battery(gateway)["other_topics"] == ["/a/battery_status", "/base/battery_state"], "both")
        assert battery(gateway, "/a")["other_topics"] == []
        with observer.publishing(state, "/battery_status"):  # a single one may come before the gateway listens
            wait_until(lambda: battery(gateway)["other_topics"] == [], "none, as there is a battery")
